//! Units of maps and of heights: the units of length of the EPSG register, the units of its projected systems and of
//! its systems of heights, and the line that converts a map in another unit.

use glam::DVec2;

/// Codes, lengths in m and names of the units of length.
const UNITS: &str = include_str!("../../data/epsg_units.csv");
/// Ranges of codes of projected systems and of systems of heights, with the codes of their units.
const SYSTEMS: &str = include_str!("../../data/epsg_systems.csv");
/// Greatest cell of a grid that may be in degrees: wider cells would be wider than the greatest cell in metres.
const MAX_CELL_DEG: f64 = 0.9;
/// Length of a degree of the equator on a map in web Mercator, in m (EPSG:3857).
const WEB_MERCATOR_M_PER_DEG: f64 = 111_319.490_793;

/// The length of a unit of the EPSG register in m, by its code.
pub(super) fn of_code(code: u16) -> Option<f64> {
    rows(UNITS).find_map(|[unit, metres, _]| (unit.parse() == Ok(code)).then(|| metres.parse().ok())?)
}

/// The length of a unit in m, by a usual name.
pub(super) fn of_name(name: &str) -> Option<f64> {
    let has_name = |names: &str| names.split('|').any(|known| known.eq_ignore_ascii_case(name));
    rows(UNITS).find_map(|[_, metres, names]| has_name(names).then(|| metres.parse().ok())?)
}

/// The unit in m of a projected system or a system of heights of the EPSG register, by its code.
pub(super) fn of_system(code: u16) -> Option<f64> {
    let number = |text: &str| text.parse().unwrap_or(0u16);
    let unit = rows(SYSTEMS).find(|[first, last, _]| (number(first)..=number(last)).contains(&code))?;
    of_code(number(unit[2]))
}

/// The unit of a map in m by a text of well-known text (Open Geospatial Consortium 2001, document 01-009): the unit that
/// the user states, or the last unit of a projected system. `corner` lies in the map, in its unit.
///
/// A map in degrees, in the Mercator projection or around the middle of the Earth is refused whatever the user states.
pub(super) fn of_well_known_text(text: &str, corner: DVec2, stated_m: Option<f64>) -> Result<f64, String> {
    // A system of heights may follow the system of the map, and a compound system holds both.
    let heights = ["VERTCS[", "VERT_CS[", "VERTCRS["].iter().filter_map(|name| text.find(name)).min();
    let text = &text[..heights.unwrap_or(text.len())];
    let kinds = ["PROJC", "GEOGC", "GEODC", "GEOCC"];
    let kind = kinds.into_iter().filter_map(|kind| Some((text.find(kind)?, kind))).min().map(|(_, kind)| kind);
    // ARC/INFO wrote lines of words.
    let has_words = |words: [&str; 2]| {
        text.lines().any(|line| line.split_whitespace().map(str::to_ascii_uppercase).take(2).eq(words))
    };
    match kind {
        Some("GEODC") if text.contains("CS[Cartesian") => return Err(geocentric()),
        Some("GEOCC") => return Err(geocentric()),
        Some("GEOGC" | "GEODC") => return Err(degrees(corner)),
        None if has_words(["PROJECTION", "GEOGRAPHIC"]) => return Err(degrees(corner)),
        _ => {}
    }
    let mercator = ["Pseudo-Mercator", "Auxiliary_Sphere", "PROJECTION[\"Mercator", "METHOD[\"Mercator"];
    if mercator.iter().any(|name| text.contains(name)) || has_words(["PROJECTION", "MERCATOR"]) {
        return Err(web_mercator(corner));
    }
    let projected = (kind == Some("PROJC")).then_some(text);
    let unit = || projected.and_then(|text| text.rsplit_once("UNIT[")?.1.split([',', ']']).nth(1)?.trim().parse().ok());
    stated_m.or_else(unit).ok_or_else(|| {
        format!("the system \"{}…\" is unknown; `map_unit` says its unit", text.chars().take(40).collect::<String>())
    })
}

/// The metre for a map that states no system, unless its coordinates may be degrees. `corners` are the west and north,
/// and the east and south.
pub(super) fn unstated(corners: [DVec2; 2], cell: DVec2) -> Result<f64, String> {
    let may_be_degrees = corners.iter().all(|corner| corner.x.abs() <= 180.0 && corner.y.abs() <= 90.0);
    if may_be_degrees && cell.max_element() <= MAX_CELL_DEG {
        let [DVec2 { x: west, y: north }, DVec2 { x: east, y: south }] = corners;
        return Err(format!(
            "the file does not say whether x = {west} to {east} and y = {south} to {north} are degrees or metres: \
             {} of degrees; `map_unit = \"m\"` says that they are metres",
            line(corners[0], "-s_srs EPSG:4326 ")
        ));
    }
    Ok(1.0)
}

/// The metre for heights of a map in metres that states no unit of heights.
pub(super) fn of_unstated_heights(map_unit_m: f64) -> Result<f64, String> {
    // The German legal metre is a metre too.
    if (map_unit_m - 1.0).abs() < 1e-3 {
        return Ok(1.0);
    }
    Err("the map is not in metres, and the file does not say the unit of its heights; `unit = \"ft\"` or `unit = \
         \"m\"` says it"
        .to_owned())
}

/// Why a map in degrees cannot be used.
pub(super) fn degrees(corner: DVec2) -> String {
    format!("the map is in degrees: {}", line(corner, ""))
}

/// Why a map around the middle of the Earth cannot be used.
pub(super) fn geocentric() -> String {
    "the map is geocentric, but must be projected".to_owned()
}

/// Why a map in web Mercator cannot be used.
pub(super) fn web_mercator(corner: DVec2) -> String {
    let DVec2 { x, y } = corner / WEB_MERCATOR_M_PER_DEG;
    let latitude_rad = y.to_radians().sinh().atan();
    let corner = DVec2::new(x, latitude_rad.to_degrees());
    format!(
        "the map is in the Mercator projection, whose lengths are {:.2} times too long there: {}",
        latitude_rad.cos().recip(),
        line(corner, "")
    )
}

/// The command that makes a map in the zone of UTM of a corner in degrees.
fn line(corner_deg: DVec2, from: &str) -> String {
    let zone = ((corner_deg.x + 180.0) / 6.0).floor().clamp(0.0, 59.0) + 1.0;
    let hemisphere = if corner_deg.y < 0.0 { 32_700.0 } else { 32_600.0 };
    format!(
        "`gdalwarp {from}-t_srs EPSG:{} -r cubic -dstnodata -9999 IN.tif OUT.tif` makes a map in metres",
        hemisphere + zone
    )
}

/// The rows of a table of three columns.
fn rows(table: &'static str) -> impl Iterator<Item = [&'static str; 3]> {
    let row = |line: &'static str| line.split(',').collect::<Vec<_>>().try_into().ok();
    table.lines().skip(1).filter_map(row)
}

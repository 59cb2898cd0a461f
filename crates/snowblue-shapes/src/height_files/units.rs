//! Units of maps and of heights: the units of length of the EPSG register, the units of its projected systems and of
//! its systems of heights, and the line that converts a map in another unit.

use glam::DVec2;

/// Codes, lengths in m and names of the units of length.
const UNITS: &str = include_str!("../../data/epsg_units.csv");
/// Ranges of codes of projected systems and of systems of heights, with the codes of their units. The unit `world` is
/// of projections of the whole Earth, and `greenwich` of those with x = 0 at Greenwich and true lengths on the equator.
const SYSTEMS: &str = include_str!("../../data/epsg_systems.csv");
/// Greatest cell of a grid that may be in degrees: wider cells would be wider than the greatest cell in metres.
const MAX_CELL_DEG: f64 = 0.9;
/// Length of a degree of the equator, in m (EPSG:3857).
const M_PER_DEG: f64 = 111_319.490_793;
/// The first words of the names of projections of the whole Earth, of Esri and of the register.
const WORLD_PROJECTIONS: &str = "aitoff|behrmann|compact miller|craster|cylindrical equal area|eckert|equal earth|\
    equidistant cylindrical|equirectangular|flat polar|gall|goode|hammer|lambert cylindrical equal area|mercator|\
    miller|mollweide|natural earth|plate carree|popular visualisation|pseudo plate carree|robinson|sinusoidal|\
    van der grinten";

/// The length of a unit of the EPSG register in m, by its code.
pub fn of_code(code: u16) -> Option<f64> {
    rows(UNITS).find_map(|[unit, metres, _]| (unit.parse() == Ok(code)).then(|| metres.parse().ok())?)
}

/// The length of a unit in m, by a usual name.
pub(super) fn of_name(name: &str) -> Option<f64> {
    let has_name = |names: &str| names.split('|').any(|known| known.eq_ignore_ascii_case(name));
    rows(UNITS).find_map(|[_, metres, names]| has_name(names).then(|| metres.parse().ok())?)
}

/// What the table of systems has for a system of the EPSG register, by its code.
fn row_of_system(code: u16) -> Option<&'static str> {
    let number = |text: &str| text.parse().unwrap_or(0u16);
    rows(SYSTEMS).find(|[first, last, _]| (number(first)..=number(last)).contains(&code)).map(|[_, _, unit]| unit)
}

/// The unit in m of a projected system or a system of heights of the EPSG register, by its code.
pub(super) fn of_system(code: u16) -> Option<f64> {
    of_code(row_of_system(code)?.parse().ok()?)
}

/// Why a map in a system of the EPSG register cannot be used, if its projection shows the whole Earth. `corner` lies in
/// the map, in m.
pub(super) fn world_system(code: u16, corner: DVec2) -> Option<String> {
    match row_of_system(code)? {
        "world" => Some(world(None)),
        "greenwich" => Some(world(Some(corner))),
        _ => None,
    }
}

/// The unit of a map in m by a text of well-known text (Open Geospatial Consortium 2001, document 01-009): the unit
/// that the user states, or the last unit of a projected system. `corner` lies in the map, in its unit.
///
/// A map in degrees, in a projection of the whole Earth or around the middle of the Earth is refused whatever the user
/// states.
pub(super) fn of_well_known_text(text: &str, corner: DVec2, stated_m: Option<f64>) -> Result<f64, String> {
    // A system of heights may follow the system of the map, and a compound system holds both.
    let heights = ["VERTCS[", "VERT_CS[", "VERTCRS["].iter().filter_map(|name| text.find(name)).min();
    let text = &text[..heights.unwrap_or(text.len())];
    let method = ["PROJECTION[\"", "METHOD[\""].iter().find_map(|key| text.split_once(key)?.1.split('"').next());
    // ARC/INFO wrote lines of two words.
    let of_arc_info = text.lines().find_map(|line| {
        let (key, value) = line.trim().split_once(char::is_whitespace)?;
        key.eq_ignore_ascii_case("projection").then(|| value.trim())
    });
    let method = method.or(of_arc_info).unwrap_or_default().to_lowercase().replace('_', " ");
    let has = |key: &str| text.contains(key);
    // A projected system holds the system of its latitudes and longitudes.
    let is_projected = has("PROJC");
    if !is_projected && (has("GEOCC") || has("CS[Cartesian")) {
        return Err(geocentric());
    }
    if !is_projected && (has("GEOGC") || has("GEODC") || method == "geographic") {
        return Err(degrees(corner));
    }
    if WORLD_PROJECTIONS.split('|').any(|name| method.starts_with(name)) {
        let is_web_map = has("Pseudo-Mercator") || has("Mercator_Auxiliary_Sphere");
        return Err(world(is_web_map.then_some(corner)));
    }
    let projected = is_projected.then_some(text);
    let unit = || projected.and_then(|text| text.rsplit_once("UNIT[")?.1.split([',', ']']).nth(1)?.trim().parse().ok());
    stated_m.or_else(unit).ok_or_else(|| {
        format!("the system \"{}…\" is unknown; `map_unit` says its unit", text.chars().take(40).collect::<String>())
    })
}

/// Refuses a map that states no system if its coordinates may be degrees. `corners` are the west and north, and the
/// east and south. Longitudes may count from -180 or from 0.
pub(super) fn check_unstated(corners: [DVec2; 2], cell: DVec2) -> Result<(), String> {
    let may_be_degrees = corners.iter().all(|corner| (-180.0..=360.0).contains(&corner.x) && corner.y.abs() <= 90.0);
    if may_be_degrees && cell.max_element() <= MAX_CELL_DEG {
        let [DVec2 { x: west, y: north }, DVec2 { x: east, y: south }] = corners;
        return Err(format!(
            "the file does not say whether x = {west} to {east} and y = {south} to {north} are degrees or metres: \
             {} of degrees; `map_unit = \"m\"` says that they are metres",
            line(Some(corners[0]), "-s_srs EPSG:4326 ")
        ));
    }
    Ok(())
}

/// The metre for heights of a map in metres that states no unit of heights.
pub(super) fn of_unstated_heights(map_unit_m: Option<f64>) -> Result<f64, String> {
    // The German legal metre is a metre too.
    if map_unit_m.is_none_or(|unit_m| (unit_m - 1.0).abs() < 1e-3) {
        return Ok(1.0);
    }
    Err("the map is not in metres, and the file does not say the unit of its heights; `unit = \"ft\"` or `unit = \
         \"m\"` says it"
        .to_owned())
}

/// Why a map in degrees cannot be used.
pub(super) fn degrees(corner: DVec2) -> String {
    format!("the map is in degrees: {}", line(Some(corner), ""))
}

/// Why a map around the middle of the Earth cannot be used.
pub(super) fn geocentric() -> String {
    "the map is geocentric, but must be projected".to_owned()
}

/// Why a map in a projection of the whole Earth cannot be used. `corner` lies in the map, in m from Greenwich and from
/// the equator along it, if that is known.
pub(super) fn world(corner: Option<DVec2>) -> String {
    let line = line(corner.map(|corner| corner / M_PER_DEG), "");
    format!("the map is in a projection of the whole Earth, whose lengths are not true: {line}")
}

/// The command that makes a map in the zone of UTM of a corner in degrees.
fn line(corner_deg: Option<DVec2>, from: &str) -> String {
    let (zone, remark) = match corner_deg {
        Some(DVec2 { x: longitude, y: latitude }) => {
            let zone = ((longitude + 180.0).rem_euclid(360.0) / 6.0).floor() + 1.0;
            ((if latitude < 0.0 { 32_700.0 } else { 32_600.0 } + zone).to_string(), "")
        }
        None => (
            "326ZZ".to_owned(),
            ", where ZZ is the zone of UTM, which is (longitude + 180)/6 rounded up, and 327ZZ is for the south",
        ),
    };
    format!(
        "`gdalwarp {from}-t_srs EPSG:{zone} -r cubic -dstnodata -9999 IN.tif OUT.tif` makes a map in metres{remark}"
    )
}

/// The rows of a table of three columns.
fn rows(table: &'static str) -> impl Iterator<Item = [&'static str; 3]> {
    let row = |line: &'static str| line.split(',').collect::<Vec<_>>().try_into().ok();
    table.lines().skip(1).filter_map(row)
}

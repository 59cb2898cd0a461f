//! Our grains against micro-tomograms: extinction, path enhancement and asymmetry, and the effect of the differences.

use snowblue_transport::measured::{Line, Point, Tomogram, fit_line, mean_and_deviation, tomograms};

use snowblue_transport::ordinates::{OrdinatesOptions, Peak, Streams};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::Incidence;
use snowblue_transport::{Demand, GrainOptics, GrainTallies, Medium, Microstructure, Population, TallyPlan};

use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable, ordinates_metadata};
use crate::plot::{Area, Axis, Chart, Entry, GREY, INK, Stroke, Symbol};
use crate::table::{Cell, DataTable};

/// The authors' letters, with names and colours for all kinds of colour vision (Okabe & Ito 2008).
const KINDS: [(&str, &str, &str); 5] = [
    ("N", "new (N)", "#56b4e9"),
    ("F", "faceted (F)", "#0072b2"),
    ("M", "mixed (M)", "#009e73"),
    ("MF", "refrozen (MF)", "#e69f00"),
    ("C", "crust (C)", "#d55e00"),
];
const OURS: Stroke = Stroke { colour: INK, width: 1.8, dashes: "" };
const TREND: Stroke = Stroke { colour: GREY, width: 1.4, dashes: "5 4" };
/// The wavelength of our n.
const INDEX_NM: f64 = 550.0;
const DEPTH_CM: f64 = 15.0;
/// Optically infinite thickness, in cm.
const INFINITE_CM: f64 = 1000.0;

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let samples = tomograms();
    let OurGrains { optics: ours, media } = our_grains();
    let mean =
        |quantity: fn(&Tomogram) -> f64| mean_and_deviation(&samples.iter().map(quantity).collect::<Vec<_>>()).mean;
    let theirs = GrainOptics {
        extinction_ratio: mean(|tomogram| tomogram.optics.extinction_ratio),
        path_enhancement: mean(|tomogram| tomogram.optics.path_enhancement),
        asymmetry: mean(|tomogram| tomogram.optics.asymmetry),
    };
    let point =
        |tomogram: &Tomogram| Point { x: tomogram.structure.density_kg_m3, y: tomogram.optics.path_enhancement };
    let trend = fit_line(&samples.iter().map(point).collect::<Vec<_>>());
    let row = |tomogram: &Tomogram| {
        let GrainOptics { extinction_ratio, path_enhancement, asymmetry } = tomogram.optics;
        let convex = tomogram.structure.convex_extinction_per_m();
        let mut cells = vec![Cell::Word(tomogram.kind.to_owned())];
        let values = [
            tomogram.structure.density_kg_m3,
            tomogram.structure.surface_area_m2_kg,
            extinction_ratio * convex,
            convex,
            path_enhancement,
            asymmetry,
        ];
        cells.extend(values.map(Cell::from));
        cells.extend([ours.path_enhancement, ours.asymmetry].map(Cell::from));
        cells
    };
    let columns = [
        "kind",
        "density_kg_m3",
        "ssa_m2_kg",
        "extinction_per_m",
        "extinction_ours_per_m",
        "B",
        "g_geometric",
        "B_ours",
        "g_ours",
    ];
    Ok(Figure {
        title: "Our grains against micro-tomograms",
        ours: format!(
            "Extinction, path enhancement B and asymmetry g (theirs without the diffraction that they add: 2g − 1) of \
             32 micro-tomograms of Letcher et al. 2022, and the lines of our grains: κ = ρ SSA/4, B = n² = {:.3} and g \
             = {:.3} (facetness .3, 550 nm). The dashed line is the linear fit to their B: {:.3} − {:.5} ρ. Nothing is \
             tuned.",
            ours.path_enhancement, ours.asymmetry, trend.offset, -trend.slope
        ),
        paper: "Describes grains by size, facetness and sphericity; it has no comparison with tomograms.".to_owned(),
        drawing: Drawing::Svg(draw(&samples, &ours, trend)),
        numbers: DataTable::new(&columns, samples.iter().map(row).collect()),
        tables: vec![kinds(&samples, &ours), effects(&media, &ours, &theirs)],
        warning: None,
    })
}

/// The default sample.
struct OurGrains {
    optics: GrainOptics,
    /// At [`COMPARED_NM`].
    media: Vec<Medium>,
}

fn our_grains() -> OurGrains {
    let (sample, options) = (SnowSample::default(), OrdinatesOptions::default());
    let plan = TallyPlan { degree: 16, rays: options.tally_rays, seed: options.seed };
    let tallies = GrainTallies::new(&Population::of_sample(&sample), &Demand::of_sample(&sample, &COMPARED_NM), &plan);
    let media = COMPARED_NM.iter().map(|nm| tallies.medium(&sample, *nm, None)).collect();
    OurGrains { optics: tallies.grain_optics(&sample, INDEX_NM), media }
}

fn kinds(samples: &[Tomogram], ours: &GrainOptics) -> FigureTable {
    let row = |name: &str, of: &[&Tomogram]| {
        let mean = |quantity: fn(&Tomogram) -> f64, decimals: usize| {
            let values = mean_and_deviation(&of.iter().map(|tomogram| quantity(tomogram)).collect::<Vec<_>>());
            format!("{:.decimals$} ± {:.decimals$}", values.mean, values.standard_deviation)
        };
        vec![
            name.to_owned(),
            of.len().to_string(),
            mean(|tomogram| tomogram.structure.density_kg_m3, 0),
            mean(|tomogram| tomogram.structure.surface_area_m2_kg, 1),
            mean(|tomogram| tomogram.optics.extinction_ratio, 3),
            mean(|tomogram| tomogram.optics.path_enhancement, 2),
            mean(|tomogram| tomogram.optics.asymmetry, 3),
        ]
    };
    let of_kind = |kind: &str| samples.iter().filter(|tomogram| tomogram.kind == kind).collect::<Vec<_>>();
    let mut rows: Vec<Vec<String>> = KINDS.iter().map(|(kind, name, _)| row(name, &of_kind(kind))).collect();
    rows.push(row("all", &samples.iter().collect::<Vec<_>>()));
    let (b, g) = (format!("{:.2}", ours.path_enhancement), format!("{:.3}", ours.asymmetry));
    rows.push(["ours", "", "", "", "1", &b, &g].map(str::to_owned).to_vec());
    let columns = ["kind", "samples", "density", "SSA", "κ / (ρ SSA/4)", "B", "g"];
    FigureTable::of_words("kinds", "Means ± standard deviations of the samples by kind (kg/m³, m²/kg)", &columns, rows)
}

/// Transmittances are compared at the first three, in nm, albedos at the last two.
const COMPARED_NM: [f64; 5] = [450.0, 550.0, 650.0, 900.0, 1030.0];

/// Transmittance of 15 cm and albedo of infinite snow with their means and with ours, at equal density and surface
/// area.
fn effects(media: &[Medium], ours: &GrainOptics, theirs: &GrainOptics) -> FigureTable {
    let sample = SnowSample::default();
    let surface_area_m2_kg = 4.0 * sample.extinction_per_m() / sample.density_kg_m3;
    let snow = Microstructure { density_kg_m3: sample.density_kg_m3, surface_area_m2_kg };
    let medium = |optics: &GrainOptics, nm: f64| {
        let absorption_per_m = sample.ice.absorption_per_m(nm);
        optics.medium(&snow, absorption_per_m)
    };
    let row = |name: &str, medium: &dyn Fn(usize) -> Medium| {
        let through = |(index, nm): (usize, &f64)| {
            let (depth_cm, incidence) = if *nm < 700.0 {
                (DEPTH_CM, Incidence::Beam { angle_deg: 0.0 })
            } else {
                (INFINITE_CM, Incidence::Diffuse)
            };
            let fluxes = medium(index).fluxes(&[depth_cm], &[incidence], Streams::Auto, Peak::Broad)[0];
            if *nm < 700.0 { format!("{:.5}", fluxes.transmittance) } else { format!("{:.4}", fluxes.reflectance) }
        };
        std::iter::once(name.to_owned()).chain(COMPARED_NM.iter().enumerate().map(through)).collect::<Vec<_>>()
    };
    let of = |optics: GrainOptics| move |index: usize| medium(&optics, COMPARED_NM[index]);
    let rows = vec![
        row("ours", &|index| media[index].clone()),
        row("ours by Henyey–Greenstein with g of 550 nm", &of(*ours)),
        row("their B", &of(GrainOptics { path_enhancement: theirs.path_enhancement, ..*ours })),
        row("their g", &of(GrainOptics { asymmetry: theirs.asymmetry, ..*ours })),
        row("their B and g", &of(GrainOptics { extinction_ratio: 1.0, ..*theirs })),
        row("their B and g and κ", &of(*theirs)),
    ];
    let columns = ["grains", "T 450", "T 550", "T 650", "albedo 900", "albedo 1030"];
    let title = format!(
        "T of 15 cm at 0°, diffuse albedo of infinite snow: 300 kg/m³, {surface_area_m2_kg:.1} m²/kg; theirs by \
         Henyey–Greenstein"
    );
    FigureTable::of_words("effects", &title, &columns, rows)
}

fn draw(samples: &[Tomogram], ours: &GrainOptics, trend: Line) -> String {
    let mut chart = Chart::new(1080.0, 430.0, "Grains of snow against micro-tomograms (Letcher et al. 2022)");
    let area = |i: usize| {
        let left = 84.0 + 310.0 * i as f64;
        Area { left, right: left + 230.0, top: 66.0, bottom: 336.0 }
    };
    let density = || Axis::linear(100.0, 700.0, 3.0);
    let convex = |tomogram: &Tomogram| tomogram.structure.convex_extinction_per_m() * 1e-3;
    let extinction = chart.panel(
        area(0),
        [Axis::linear(0.4, 1.6, 4.0), Axis::linear(0.2, 1.6, 4.0)],
        ["ρ SSA/4 (1/mm)", "Extinction (1/mm)"],
    );
    let paths =
        chart.panel(area(1), [density(), Axis::linear(1.0, 2.0, 5.0)], ["Density (kg/m³)", "Path enhancement B"]);
    let asymmetry =
        chart.panel(area(2), [density(), Axis::linear(0.55, 0.75, 4.0)], ["Density (kg/m³)", "Asymmetry g"]);
    chart.line(&extinction, &[(0.4, 0.4), (1.6, 1.6)], OURS);
    chart.line(&paths, &[(100.0, ours.path_enhancement), (700.0, ours.path_enhancement)], OURS);
    chart.line(&paths, &[100.0, 700.0].map(|rho| (rho, trend.offset + trend.slope * rho)), TREND);
    chart.line(&asymmetry, &[(100.0, ours.asymmetry), (700.0, ours.asymmetry)], OURS);
    for (kind, _, colour) in KINDS {
        let points = |quantity: &dyn Fn(&Tomogram) -> (f64, f64)| -> Vec<(f64, f64)> {
            samples.iter().filter(|tomogram| tomogram.kind == kind).map(quantity).collect()
        };
        let extinction_points =
            points(&|tomogram| (convex(tomogram), tomogram.optics.extinction_ratio * convex(tomogram)));
        chart.dots(&extinction, &extinction_points, colour);
        chart.dots(
            &paths,
            &points(&|tomogram| (tomogram.structure.density_kg_m3, tomogram.optics.path_enhancement)),
            colour,
        );
        chart.dots(
            &asymmetry,
            &points(&|tomogram| (tomogram.structure.density_kg_m3, tomogram.optics.asymmetry)),
            colour,
        );
    }
    let mut entries = vec![
        Entry { name: "ours", symbol: Symbol::Line(OURS) },
        Entry { name: "line through B", symbol: Symbol::Line(TREND) },
    ];
    entries.extend(KINDS.iter().map(|(_, name, colour)| Entry { name, symbol: Symbol::Dot(colour) }));
    chart.legend((950.0, 80.0), "", &entries);
    chart.finish(&ordinates_metadata(&[
        ("ours at", "550 nm"),
        ("dots", "Letcher et al. 2022, doi:10.5194/tc-16-4343-2022"),
    ]))
}

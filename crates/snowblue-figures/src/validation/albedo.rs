//! Surface area and black carbon retrieved from the albedo of thick snow, and the albedo of thin snow predicted.

use snowblue_transport::batch::{Batch, BatchError, SlabCase};
use snowblue_transport::inversion::{
    Illumination, Inversion, InversionError, Measured, Observation, Outcome, Prior, Quantity, Retrieval, Retrieved,
};
use snowblue_transport::measured::{MeanAndDeviation, PanelAlbedo, albedo_over_black_panels};
use snowblue_transport::ordinates::{OrdinatesOptions, solve_batch};
use snowblue_transport::sample::{GrainSize, SnowSample};
use snowblue_transport::{Incidence, Layer, LayerVariable, Substance, TransportError, Variable};

use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable, ordinates_metadata};
use crate::plot::{Area, Axis, Chart, Entry, Fill, GREY, INK, Stroke, Symbol};
use crate::table::{Cell, DataTable};

const THICK_CM: f64 = 34.0;
const THIN_CM: f64 = 4.5;
/// The ground under the thick snow, old grass or frozen soil, is not described; its albedo has no effect.
const GROUND_ALBEDO: f64 = 0.15;
/// Densities and panel albedos, which are not reported: ends and middle of plausible ranges.
const DENSITIES_KG_M3: [f64; 3] = [147.0, 217.0, 287.0];
const PANEL_ALBEDOS: [f64; 3] = [0.02, 0.04, 0.06];
/// Bands for the errors, in nm.
const BANDS_NM: [(f64, f64); 5] = [(400.0, 500.0), (500.0, 700.0), (700.0, 900.0), (900.0, 1100.0), (1100.0, 1300.0)];
/// Beyond this wavelength 4.5 cm are optically infinite, in nm.
const INFINITE_FROM_NM: f64 = 1000.0;
/// Distance over which the errors of measurement and model correlate, in nm: the width of the residuals' features.
const CORRELATION_NM: f64 = 50.0;
/// Standard deviation of the white reference: the authors scaled by 0.965.
const SCALE_ERROR: f64 = 0.035;
/// Angle of the sun at noon of the day of the measurement, in degrees.
const NOON_DEG: f64 = 58.0;
const VARIABLES: [Variable; 2] = [Variable::SurfaceArea, Variable::MassFraction(Substance::BlackCarbon)];
/// The retrieval from which the thin snow is predicted.
const CHOSEN: usize = 1;
/// Retrievals at wavelengths at which both snows are optically infinite.
const INFRARED: [usize; 2] = [4, 5];

/// Retrievals and predictions.
struct Answers {
    measured: Vec<PanelAlbedo>,
    retrievals: Vec<(&'static str, Retrieval)>,
    /// The albedo of the thick snow by the chosen retrieval.
    thick: Vec<f64>,
    thin: Prediction,
    /// Prediction with the surface area of the thin snow itself.
    thin_refitted: Prediction,
}

/// The properties that are retrieved.
#[derive(Clone, Copy)]
struct Finding {
    surface_area_m2_kg: f64,
    black_carbon_ng_g: f64,
}

/// The albedo of the thin snow, for the middle and the ends of the unknown quantities.
struct Prediction {
    middle: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
}

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let answers = answers()?;
    let row = |(i, albedo): (usize, &PanelAlbedo)| {
        let mut row = vec![albedo.wavelength_nm, albedo.thick.mean, albedo.thick.standard_deviation, answers.thick[i]];
        row.push(answers.thick[i] - albedo.thick.mean);
        row.extend([albedo.thin.mean, albedo.thin.standard_deviation]);
        for thin in [&answers.thin, &answers.thin_refitted] {
            row.extend([thin.middle[i], thin.low[i], thin.high[i], thin.middle[i] - albedo.thin.mean]);
        }
        row.into_iter().map(Cell::from).collect()
    };
    let columns = [
        "wavelength_nm",
        "thick_measured",
        "thick_deviation",
        "thick_fitted",
        "thick_residual",
        "thin_measured",
        "thin_deviation",
        "thin_predicted",
        "thin_low",
        "thin_high",
        "thin_residual",
        "thin_refitted",
        "thin_refitted_low",
        "thin_refitted_high",
        "thin_refitted_residual",
    ];
    Ok(Figure {
        title: "Snow from its albedo, and thin snow predicted from it",
        ours: "Top: measured albedo (Letcher et al. 2022, Vermont, 12 February 2021, sky light; bands ± 1 standard \
               deviation) of 34 cm of snow, with that of the snow that we retrieve, and of 4.5 cm on a black panel, \
               with our prediction for the same snow. The band spans densities of 147–287 kg/m³ and panel albedos of \
               .02–.06, which are not reported. Dashed: prediction with the surface area of the thin snow beyond 1000 \
               nm, where the panel has no effect. Middle: ours minus measured. Bottom: thin over thick, which does not \
               depend on a common error of scale or of the ice table; grey is the band of the dashed line."
            .to_owned(),
        paper: "Compares its model with one measured reflectance (Fig. S2), not with these measurements.".to_owned(),
        drawing: Drawing::Svg(draw(&answers)),
        numbers: DataTable::new(&columns, answers.measured.iter().enumerate().map(row).collect()),
        tables: vec![fits(&answers), bands(&answers), ratios(&answers)],
        warning: None,
    })
}

fn answers() -> Result<Answers, TransportError> {
    let measured = albedo_over_black_panels();
    let (names, observations): (Vec<&'static str>, Vec<Observation>) = observations(&measured).into_iter().unzip();
    let deviations = VARIABLES.map(|variable| Prior::weak(variable).deviation);
    let inversion = Inversion {
        wavelengths_nm: measured.iter().map(|albedo| albedo.wavelength_nm).collect(),
        bands: None,
        variables: VARIABLES.map(LayerVariable::from).to_vec(),
        prior_covariance: vec![deviations[0].powi(2), 0.0, 0.0, deviations[1].powi(2)],
        options: OrdinatesOptions::default(),
    };
    let retrievals = inversion.retrieve(&observations, &|_| ()).map_err(|InversionError { error, .. }| *error)?;
    let finding = Finding::of(&retrievals[CHOSEN]);
    let own = Finding { surface_area_m2_kg: Finding::of(&retrievals[INFRARED[1]]).surface_area_m2_kg, ..finding };
    Ok(Answers {
        thick: retrievals[CHOSEN].fits[0].clone(),
        thin: predict(&inversion.wavelengths_nm, finding)?,
        thin_refitted: predict(&inversion.wavelengths_nm, own)?,
        retrievals: names.into_iter().zip(retrievals).collect(),
        measured,
    })
}

/// What is retrieved from, with its name.
fn observations(measured: &[PanelAlbedo]) -> Vec<(&'static str, Observation)> {
    let data = |of: fn(&PanelAlbedo) -> MeanAndDeviation, from_nm: f64, correlation_nm: f64| Measured {
        quantity: Quantity::Albedo,
        depths_cm: Vec::new(),
        values: measured
            .iter()
            .map(|albedo| if albedo.wavelength_nm < from_nm { f64::NAN } else { of(albedo).mean })
            .collect(),
        standard_deviations: measured.iter().map(|albedo| of(albedo).standard_deviation).collect(),
        scale_error: 0.0,
        correlation_nm,
    };
    let layer = |thickness_cm| vec![Layer::snow(snow(), thickness_cm)];
    let thick = |albedo: Measured| Observation {
        layers: layer(THICK_CM),
        ground_albedo: GROUND_ALBEDO,
        illumination: Illumination::Single(Incidence::Diffuse),
        prior_medians: VARIABLES.iter().filter_map(|variable| Prior::weak(*variable).median).collect(),
        measured: vec![albedo],
    };
    let whole = data(|albedo| albedo.thick, 0.0, CORRELATION_NM);
    let infrared = data(|albedo| albedo.thick, INFINITE_FROM_NM, CORRELATION_NM);
    let thin = data(|albedo| albedo.thin, INFINITE_FROM_NM, CORRELATION_NM);
    vec![
        ("34 cm, independent errors", thick(data(|albedo| albedo.thick, 0.0, 0.0))),
        ("34 cm", thick(whole.clone())),
        ("34 cm, scale within 3.5 %", thick(Measured { scale_error: SCALE_ERROR, ..whole.clone() })),
        (
            "34 cm, if the light was the noon sun",
            Observation {
                illumination: Illumination::Single(Incidence::Beam { angle_deg: NOON_DEG }),
                ..thick(Measured { scale_error: SCALE_ERROR, ..whole })
            },
        ),
        ("34 cm, from 1000 nm", thick(infrared)),
        ("4.5 cm, from 1000 nm", Observation { layers: layer(THIN_CM), ground_albedo: 0.0, ..thick(thin) }),
    ]
}

fn snow() -> SnowSample {
    SnowSample { density_kg_m3: DENSITIES_KG_M3[1], ..SnowSample::default() }
}

impl Finding {
    fn of(retrieval: &Retrieval) -> Self {
        let [surface_area_m2_kg, black_carbon_ng_g] = [0, 1].map(|i: usize| retrieval.values[i].median);
        Self { surface_area_m2_kg, black_carbon_ng_g }
    }
}

/// The thin snow on its panel, for the middle and the ends of density and panel albedo.
fn predict(wavelengths_nm: &[f64], finding: Finding) -> Result<Prediction, TransportError> {
    let snow = snow();
    let grain_size = GrainSize::from_specific_surface_area(finding.surface_area_m2_kg, snow.temperature_c)?;
    let impurities = snow.impurities.with(Substance::BlackCarbon, finding.black_carbon_ng_g);
    let sample = |density_kg_m3: &f64| SnowSample { density_kg_m3: *density_kg_m3, grain_size, impurities, ..snow };
    // The middle, the darkest and the brightest.
    let case = |place: usize| SlabCase {
        sample: place,
        thickness_cm: THIN_CM,
        incidence: Incidence::Diffuse,
        ground_albedo: PANEL_ALBEDOS[place],
    };
    let batch = Batch {
        samples: DENSITIES_KG_M3.iter().map(sample).collect(),
        cases: (0..3).map(case).collect(),
        wavelengths_nm: wavelengths_nm.to_vec(),
    };
    let solved = solve_batch(&batch, &OrdinatesOptions::default(), false, &|_| ());
    let solved = solved.map_err(|BatchError { error, .. }| error)?;
    let mut spectra = solved
        .chunks_exact(wavelengths_nm.len())
        .map(|rows| rows.iter().map(|row| row.reflectance.value).collect::<Vec<f64>>());
    let mut next = || spectra.next().unwrap_or_default();
    let (low, middle, high) = (next(), next(), next());
    Ok(Prediction { middle, low, high })
}

fn fits(answers: &Answers) -> FigureTable {
    let with_interval = |value: &Retrieved, decimals: usize| {
        let [low, high] = value.interval;
        format!("{:.decimals$} ({low:.decimals$}–{high:.decimals$})", value.median)
    };
    let row = |(name, found): &(&'static str, Retrieval)| {
        let [area, carbon] = [0, 1].map(|i: usize| found.values[i]);
        let scale = found.scales[0];
        let is_scaled = scale.standard_deviation > 0.0;
        let kernel = |i: usize| format!("{:.2}", found.averaging_kernel[3 * i]);
        vec![
            (*name).to_owned(),
            with_interval(&area, 1),
            with_interval(&carbon, 1),
            if is_scaled { with_interval(&scale, 3) } else { "1".to_owned() },
            kernel(0),
            kernel(1),
            format!("{:.2}", found.chi_square / found.data as f64),
            match &found.outcome {
                Outcome::Converged => found.solutions.to_string(),
                outcome => outcome.to_string(),
            },
        ]
    };
    let columns = [
        "retrieved from",
        "SSA (m²/kg)",
        "BC (ng/g)",
        "measured / true",
        "A of SSA",
        "A of BC",
        "χ²/data",
        "solutions",
    ];
    FigureTable::of_words(
        "fit",
        "Snow from its albedo, with the interval that holds 95 % of the posterior",
        &columns,
        answers.retrievals.iter().map(row).collect(),
    )
}

fn bands(answers: &Answers) -> FigureTable {
    let row = |(low, high): (f64, f64), name: String| {
        let within = |albedo: &PanelAlbedo| (low..=high).contains(&albedo.wavelength_nm);
        let indices: Vec<usize> = (0..answers.measured.len()).filter(|i| within(&answers.measured[*i])).collect();
        let error = |ours: &[f64], of: fn(&PanelAlbedo) -> f64| {
            let squares: f64 = indices.iter().map(|i| (ours[*i] - of(&answers.measured[*i])).powi(2)).sum();
            let mean: f64 = indices.iter().map(|i| ours[*i] - of(&answers.measured[*i])).sum();
            let count = indices.len() as f64;
            format!("{:.4} ({:+.4})", (squares / count).sqrt(), mean / count)
        };
        vec![
            name,
            error(&answers.thick, |albedo| albedo.thick.mean),
            error(&answers.thin.middle, |albedo| albedo.thin.mean),
            error(&answers.thin_refitted.middle, |albedo| albedo.thin.mean),
        ]
    };
    let mut rows: Vec<Vec<String>> = BANDS_NM.iter().map(|band| row(*band, format!("{}–{}", band.0, band.1))).collect();
    rows.push(row((400.0, 1300.0), "400–1300".to_owned()));
    let columns = ["nm", "34 cm retrieved", "4.5 cm predicted", "4.5 cm own SSA"];
    FigureTable::of_words("bands", "Root mean square (and mean) of ours less measured", &columns, rows)
}

/// Thin over thick, measured and predicted, for the middle and the ends of the unknown quantities.
fn ratios(answers: &Answers) -> FigureTable {
    let row = |nm: &f64| {
        let index = answers.measured.iter().position(|albedo| albedo.wavelength_nm >= *nm).unwrap_or_default();
        let albedo = &answers.measured[index];
        let ours = |thin: &Prediction| {
            let over = |thin: &[f64]| thin[index] / answers.thick[index];
            format!("{:.3} ({:.3}–{:.3})", over(&thin.middle), over(&thin.low), over(&thin.high))
        };
        vec![
            nm.to_string(),
            format!("{:.3}", albedo.thin.mean / albedo.thick.mean),
            ours(&answers.thin),
            ours(&answers.thin_refitted),
        ]
    };
    let columns = ["nm", "measured", "same snow", "own SSA"];
    let rows = [400.0, 500.0, 600.0, 700.0, 800.0, 900.0, 1000.0, 1100.0, 1200.0, 1300.0].iter().map(row).collect();
    FigureTable::of_words(
        "ratio",
        "Albedo of 4.5 cm over that of 34 cm; in brackets for the ends of density and panel",
        &columns,
        rows,
    )
}

const THICK: &str = "#0072b2";
const THIN: &str = "#d55e00";

fn draw(answers: &Answers) -> String {
    let mut chart = Chart::new(960.0, 900.0, "Albedo of snow in Vermont: retrieved where thick, predicted where thin");
    let axis = || Axis::linear(400.0, 1300.0, 9.0);
    let area = |top, bottom| Area { left: 84.0, right: 700.0, top, bottom };
    let upper = chart.panel(area(66.0, 390.0), [axis(), Axis::linear(0.4, 1.0, 6.0)], ["", "Albedo"]);
    let middle = chart.panel(area(430.0, 600.0), [axis(), Axis::linear(-0.04, 0.08, 6.0)], ["", "Ours less measured"]);
    let names = ["Wavelength (nm)", "4.5 cm over 34 cm"];
    let lower = chart.panel(area(640.0, 810.0), [axis(), Axis::linear(0.9, 1.02, 6.0)], names);
    let sets: [fn(&PanelAlbedo) -> MeanAndDeviation; 2] = [|albedo| albedo.thick, |albedo| albedo.thin];
    for (colour, of) in [THICK, THIN].into_iter().zip(sets) {
        let measured = |sign: f64| answers.curve(|albedo, _| of(albedo).mean + sign * of(albedo).standard_deviation);
        chart.band(&upper, [&measured(-1.0), &measured(1.0)], Fill { colour: GREY, opacity: 0.25 });
        chart.sized_dots(&upper, &measured(0.0), colour, 1.7);
    }
    chart.line(&middle, &[(400.0, 0.0), (1300.0, 0.0)], Stroke::solid(GREY, 1.2));
    for (number, panel) in [&upper, &middle, &lower].into_iter().enumerate() {
        let curve = |thin: &[f64]| match number {
            0 => answers.curve(|_, i| thin[i]),
            1 => answers.curve(|albedo, i| thin[i] - albedo.thin.mean),
            _ => answers.curve(|_, i| thin[i] / answers.thick[i]),
        };
        let Prediction { middle, low, high } = &answers.thin;
        chart.band(panel, [&curve(low), &curve(high)], Fill { colour: THIN, opacity: 0.2 });
        let own = &answers.thin_refitted;
        if number == 2 {
            chart.band(panel, [&curve(&own.low), &curve(&own.high)], Fill { colour: INK, opacity: 0.12 });
        }
        chart.line(panel, &curve(middle), Stroke::solid(THIN, 1.8));
        chart.line(panel, &curve(&own.middle), OWN);
    }
    chart.sized_dots(&lower, &answers.curve(|albedo, _| albedo.thin.mean / albedo.thick.mean), THIN, 1.7);
    chart.line(&upper, &answers.curve(|_, i| answers.thick[i]), Stroke::solid(THICK, 1.8));
    chart.line(&middle, &answers.curve(|albedo, i| answers.thick[i] - albedo.thick.mean), Stroke::solid(THICK, 1.8));
    legend(&mut chart);
    let found = Finding::of(&answers.retrievals[CHOSEN].1);
    let snow = format!("SSA {:.1} m²/kg, black carbon {:.0} ng/g", found.surface_area_m2_kg, found.black_carbon_ng_g);
    chart.finish(&ordinates_metadata(&[("ice", "warren2008"), ("snow", &snow), ("measured", "Letcher et al. 2022")]))
}

const OWN: Stroke = Stroke { colour: THIN, width: 2.0, dashes: "7 4" };

impl Answers {
    /// A quantity at each wavelength, from the measurement and its index.
    fn curve(&self, quantity: impl Fn(&PanelAlbedo, usize) -> f64) -> Vec<(f64, f64)> {
        self.measured.iter().enumerate().map(|(i, albedo)| (albedo.wavelength_nm, quantity(albedo, i))).collect()
    }
}

fn legend(chart: &mut Chart) {
    let below = chart.legend(
        (728.0, 80.0),
        "34 cm",
        &[
            Entry { name: "measured", symbol: Symbol::Dot(THICK) },
            Entry { name: "retrieved by us", symbol: Symbol::Line(Stroke::solid(THICK, 2.0)) },
        ],
    );
    let below = chart.legend(
        (728.0, below),
        "4.5 cm over a black panel",
        &[
            Entry { name: "measured", symbol: Symbol::Dot(THIN) },
            Entry { name: "predicted from 34 cm", symbol: Symbol::Line(Stroke::solid(THIN, 2.0)) },
            Entry { name: "density, panel unknown", symbol: Symbol::Band(Fill { colour: THIN, opacity: 0.25 }) },
            Entry { name: "by its own SSA", symbol: Symbol::Line(OWN) },
            Entry { name: "… and unknown, below", symbol: Symbol::Band(Fill { colour: INK, opacity: 0.1 }) },
        ],
    );
    chart.legend(
        (728.0, below),
        "",
        &[Entry { name: "± 1 deviation", symbol: Symbol::Band(Fill { colour: INK, opacity: 0.2 }) }],
    );
}

//! What becomes of colours that a screen cannot show: laws, and how far the hue moves for an eye that was not asked
//! when the method was made.

use snowblue_color::{LinearRgb, Observer, Oklab, RgbSpace, Xyz};

/// Light through 30, 50 and 60 cm of snow (400 µm, facetness 0.3, 300 kg/m³) under D65, by the ordinates engine, and
/// through 60 cm under LED-B5; the bare light has Y = 1.
const DEEP: [(&str, Xyz); 4] = [
    ("30 cm", Xyz { x: 0.004_710_19, y: 0.005_768_65, z: 0.011_321_29 }),
    ("50 cm", Xyz { x: 0.001_600_10, y: 0.001_759_91, z: 0.006_252_02 }),
    ("60 cm", Xyz { x: 0.001_100_87, y: 0.001_051_68, z: 0.004_941_04 }),
    ("60 cm, LED-B5", Xyz { x: 0.001_196_15, y: 0.000_951_82, z: 0.005_207_84 }),
];

/// Hue in degrees in IPT (Ebner & Fairchild 1998, *Development and testing of a color space (IPT) with improved hue
/// uniformity*, Proc. IS&T 6th Color Imaging Conference, 8), which was made from other observers' hues than Oklab.
fn ipt_hue_deg(Xyz { x, y, z }: Xyz) -> f64 {
    let response = |cone: f64| cone.signum() * cone.abs().powf(0.43);
    let l = response(0.4002 * x + 0.7075 * y - 0.0807 * z);
    let m = response(-0.2280 * x + 1.1500 * y + 0.0612 * z);
    let s = response(0.9184 * z);
    let p = 4.4550 * l - 4.8510 * m + 0.3960 * s;
    let t = 0.8056 * l + 0.3572 * m - 1.1628 * s;
    t.atan2(p).to_degrees().rem_euclid(360.0)
}

fn oklab_hue_deg(xyz: Xyz) -> f64 {
    Oklab::from_xyz(xyz).hue_deg()
}

fn turn_deg(from: f64, to: f64) -> f64 {
    (to - from + 180.0).rem_euclid(360.0) - 180.0
}

/// The straight way to grey in linear RGB, at constant luminance.
fn straight_to_grey(colour: LinearRgb) -> LinearRgb {
    let grey = colour.luminance();
    let share = (grey / (grey - colour.r.min(colour.g).min(colour.b))).min(1.0);
    let [r, g, b] = [colour.r, colour.g, colour.b].map(|channel| grey + share * (channel - grey));
    LinearRgb { r, g, b }
}

#[test]
fn blues_of_deep_snow_keep_their_hue_to_the_eye() {
    for (place, xyz) in DEEP {
        let shown = LinearRgb::from_xyz(xyz).into_gamut().xyz();
        let turned =
            [turn_deg(oklab_hue_deg(xyz), oklab_hue_deg(shown)), turn_deg(ipt_hue_deg(xyz), ipt_hue_deg(shown))];
        // In Oklab the steps leave 0.04° at 60 cm. In IPT the hue turns by as much as the two spaces
        // disagree, 0.6° at 60 cm; the limit is half of the least that the straight way does.
        assert!(turned[0].abs() < 0.05 && turned[1].abs() < 0.95, "{place}: {turned:?}");
    }
    // What the straight way does, so that the limit above is seen to tell the ways apart.
    let turned =
        DEEP.map(|(_, xyz)| turn_deg(ipt_hue_deg(xyz), ipt_hue_deg(straight_to_grey(LinearRgb::from_xyz(xyz)).xyz())));
    assert!(turned[0].abs() < 1e-9 && turned[1..].iter().all(|turn| *turn > 1.9), "{turned:?}");
}

/// Monochromatic light mixed with white, from dark to glaring.
fn real_lights() -> Vec<Xyz> {
    let white = RgbSpace::Srgb.white();
    let mut lights = Vec::new();
    for step in 0..=60 {
        let spectral = Observer::Cie1931.matching(400.0 + 5.0 * f64::from(step)).expect("within the table");
        for mixed in 1..=10 {
            let share = f64::from(mixed) / 10.0;
            let light = spectral * (share / spectral.y) + white * (1.0 - share);
            lights.extend([0.001, 0.1, 0.3, 0.6, 0.95, 1.5].map(|luminance| light * luminance));
        }
    }
    lights
}

#[test]
fn every_light_becomes_a_colour_of_the_screen_with_its_luminance_and_hue() {
    for light in real_lights() {
        let within = LinearRgb::from_xyz(light).into_gamut();
        assert!(within.r >= 0.0 && within.g >= 0.0 && within.b >= 0.0, "{light:?} {within:?}");
        assert!((within.luminance() / light.y - 1.0).abs() < 1e-12, "{light:?} {within:?}");
        let shown = LinearRgb::from_xyz(light).displayable();
        assert!([shown.r, shown.g, shown.b].iter().all(|channel| (0.0..=1.0).contains(channel)), "{light:?} {shown:?}");
        assert!((shown.luminance() - light.y.min(1.0)).abs() < 1e-12, "{light:?} {shown:?}");
        for colour in [within, shown] {
            let lab = Oklab::from_xyz(colour.xyz());
            if lab.chroma() > 0.01 {
                let turned = turn_deg(oklab_hue_deg(light), lab.hue_deg());
                // What the steps leave to the straight way.
                assert!(turned.abs() < 0.35, "{light:?} {colour:?}: {turned}");
            }
        }
    }
}

/// The greatest change of what is shown from one step to the next, along a line of lights.
fn greatest_step(count: u32, light: impl Fn(f64) -> Xyz) -> f64 {
    let shown: Vec<LinearRgb> =
        (0..=count).map(|step| LinearRgb::from_xyz(light(f64::from(step) / f64::from(count))).displayable()).collect();
    let far = |pair: &[LinearRgb]| {
        let [r, g, b] = [pair[0].r - pair[1].r, pair[0].g - pair[1].g, pair[0].b - pair[1].b];
        r.abs().max(g.abs()).max(b.abs())
    };
    shown.windows(2).map(far).fold(0.0, f64::max)
}

/// A tenth of the step changes what is shown by a tenth, up to bends and steep places: there is no jump. From grey through the border of
/// the gamut to the spectral colours, and along these.
#[test]
fn neighbours_are_shown_as_neighbours() {
    let white = RgbSpace::Srgb.white();
    let spectral = |wavelength_nm: f64| {
        let matching = Observer::Cie1931.matching(wavelength_nm).expect("within the table");
        matching * matching.y.recip()
    };
    for luminance in [0.05, 0.2, 0.7] {
        let along_the_spectrum = |place: f64| spectral(410.0 + 250.0 * place) * luminance;
        let (coarse, fine) = (greatest_step(2_500, along_the_spectrum), greatest_step(25_000, along_the_spectrum));
        assert!(fine < 0.2 * coarse, "Y = {luminance}: {coarse} {fine}");
        for wavelength_nm in [430.0, 450.0, 460.0, 470.0, 480.0, 520.0, 600.0, 650.0] {
            let from_grey = |share: f64| (spectral(wavelength_nm) * share + white * (1.0 - share)) * luminance;
            let (coarse, fine) = (greatest_step(1_000, from_grey), greatest_step(10_000, from_grey));
            assert!(fine < 0.2 * coarse, "{wavelength_nm} nm, Y = {luminance}: {coarse} {fine}");
        }
    }
}

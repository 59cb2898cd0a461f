//! Gamut mapping: invariants, continuity, and hue shifts in Oklab, which the method uses, and in IPT, which it does
//! not.

use snowblue_color::{LinearRgb, Observer, Oklab, RgbSpace, Xyz};

/// Daylight (D65) through 5–100 cm of snow of 100, 400 and 2000 µm (facetness 0.3, 300 kg/m³) by the ordinates engine:
/// grain size in µm, thickness in cm, X, Y, Z; the bare light has Y = 1.
const SNOW: &str = include_str!("../data/light_through_snow.csv");

/// Hue in degrees in IPT (Ebner & Fairchild 1998, *Development and testing of a color space (IPT) with improved hue
/// uniformity*, Proc. IS&T 6th Color Imaging Conference, 8), which was fitted to other hue data than Oklab.
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

fn hue_shift_deg(from: f64, to: f64) -> f64 {
    (to - from + 180.0).rem_euclid(360.0) - 180.0
}

/// Monochromatic light mixed with white, from dark to very bright.
fn real_lights() -> Vec<Xyz> {
    let white = RgbSpace::Srgb.white();
    let mut lights = Vec::new();
    for step in 0..=60 {
        let spectral = Observer::Cie1931.color_matching(400.0 + 5.0 * f64::from(step)).expect("within the table");
        for mixed in 1..=10 {
            let fraction = f64::from(mixed) / 10.0;
            let light = spectral * (fraction / spectral.y) + white * (1.0 - fraction);
            lights.extend([0.001, 0.1, 0.3, 0.6, 0.95, 1.5].map(|luminance| light * luminance));
        }
    }
    lights
}

/// The distance of two colours in Oklab.
fn distance(first: Xyz, second: Xyz) -> f64 {
    let (first, second) = (Oklab::from_xyz(first), Oklab::from_xyz(second));
    (first.l - second.l).hypot(first.a - second.a).hypot(first.b - second.b)
}

fn rgb(channels: [f64; 3]) -> LinearRgb {
    LinearRgb { r: channels[0], g: channels[1], b: channels[2] }
}

fn at_luminance(light: Xyz, luminance: f64) -> LinearRgb {
    LinearRgb::from_xyz(light.with_luminance(luminance))
}

#[test]
fn every_light_becomes_displayable_with_its_luminance() {
    for light in real_lights() {
        let within = LinearRgb::from_xyz(light).into_gamut();
        assert!(within.r >= 0.0 && within.g >= 0.0 && within.b >= 0.0, "{light:?} {within:?}");
        assert!((within.luminance() / light.y - 1.0).abs() < 1e-12, "{light:?} {within:?}");
        let shown = LinearRgb::from_xyz(light).displayable();
        assert!([shown.r, shown.g, shown.b].iter().all(|channel| (0.0..=1.0).contains(channel)), "{light:?} {shown:?}");
        assert!((shown.luminance() - light.y.min(1.0)).abs() < 1e-12, "{light:?} {shown:?}");
    }
}

/// Lights 5·10⁻⁵ to 0.05 outside the gamut boundary, including at and near the primaries. With a hue weight of 4 the
/// mapped colour may be 4 times as far away as the nearest one.
#[test]
fn a_light_just_outside_the_gamut_moves_little() {
    let mut checked = 0;
    for channel in 0..3 {
        for position in [
            0.0, 1e-6, 1e-4, 0.001, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 0.97, 0.99, 0.999,
            0.9999, 1.0,
        ] {
            let mut channels = [0.0; 3];
            (channels[(channel + 1) % 3], channels[(channel + 2) % 3]) = (position, 1.0 - position);
            let border = rgb(channels);
            for direction in
                [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, -1.0, 0.0], [0.0, -1.0, -1.0]]
            {
                for step in [1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
                    let moved = rgb([0, 1, 2].map(|channel| channels[channel] + step * direction[channel]));
                    let outside = at_luminance(moved.xyz(), border.luminance());
                    let away = distance(outside.xyz(), border.xyz());
                    if outside.r.min(outside.g).min(outside.b) >= 0.0 || !(5e-5..0.05).contains(&away) {
                        continue;
                    }
                    checked += 1;
                    for shown in [outside.into_gamut(), outside.displayable()] {
                        let moved = distance(shown.xyz(), outside.xyz());
                        assert!(moved < 4.0 * away, "{border:?}, {away} outside: {moved}");
                    }
                }
            }
        }
    }
    assert!(checked > 400, "{checked}");
}

/// The greatest ratio of distances between neighbours, after and before mapping, along a line of lights.
fn greatest_spread(count: u32, light: impl Fn(f64) -> LinearRgb, show: impl Fn(LinearRgb) -> LinearRgb) -> f64 {
    let lights: Vec<LinearRgb> = (0..=count).map(|step| light(f64::from(step) / f64::from(count))).collect();
    let spread = |pair: &[LinearRgb]| {
        distance(show(pair[0]).xyz(), show(pair[1]).xyz()) / distance(pair[0].xyz(), pair[1].xyz())
    };
    lights.windows(2).map(spread).fold(0.0, f64::max)
}

/// From grey across the gamut boundary to the spectral colours, and along these. The limits are the measured values,
/// rounded up: 2.3 up to half of the spectral purity, 9.4 for spectral lights, near 466 nm. A discontinuity of 0.1
/// would give 300 and more on lines of 4,000 steps.
#[test]
fn neighbours_stay_neighbours() {
    let white = RgbSpace::Srgb.white();
    let spectral = |wavelength_nm: f64| {
        let matching = Observer::Cie1931.color_matching(wavelength_nm).expect("within the table");
        matching * matching.y.recip()
    };
    for luminance in [0.01, 0.05, 0.2, 0.7] {
        let mixed = |wavelength_nm: f64, purity: f64| {
            at_luminance(spectral(wavelength_nm) * purity + white * (1.0 - purity), luminance)
        };
        let check = |name: String, limit: f64, light: &dyn Fn(f64) -> LinearRgb| {
            let spreads = [
                greatest_spread(4_000, light, LinearRgb::into_gamut),
                greatest_spread(4_000, light, LinearRgb::displayable),
            ];
            assert!(spreads.iter().all(|spread| *spread < limit), "{name}, Y = {luminance}: {spreads:?}");
        };
        for purity in [0.03, 0.1, 0.2, 0.3, 0.5, 0.8, 1.0] {
            check(format!("purity {purity}"), if purity > 0.5 { 10.0 } else { 2.5 }, &|position| {
                mixed(410.0 + 250.0 * position, purity)
            });
        }
        for wavelength_nm in [430.0, 450.0, 460.0, 465.0, 470.0, 475.0, 480.0, 520.0, 600.0, 650.0] {
            check(format!("{wavelength_nm} nm"), 2.5, &|position| mixed(wavelength_nm, position));
        }
    }
}

/// Hue shifts of the gamut mapping in degrees, and the fraction of chroma over lightness that it keeps.
struct Mapping {
    oklab_shift_deg: f64,
    ipt_shift_deg: f64,
    kept_saturation: f64,
}

fn map(light: Xyz) -> Mapping {
    let mapped = LinearRgb::from_xyz(light).into_gamut().xyz();
    let saturation = |xyz: Xyz| {
        let lab = Oklab::from_xyz(xyz);
        lab.chroma() / lab.l
    };
    Mapping {
        oklab_shift_deg: hue_shift_deg(oklab_hue_deg(light), oklab_hue_deg(mapped)),
        ipt_shift_deg: hue_shift_deg(ipt_hue_deg(light), ipt_hue_deg(mapped)),
        kept_saturation: saturation(mapped) / saturation(light),
    }
}

/// Limits in Oklab: the shift at the steepest point of the boundary, next to the blue primary, rounded up. In IPT: the
/// same up to the hue of this primary, 264° in Oklab; for violet hues beyond, the disagreement of Oklab and IPT. On the
/// straight line to grey, hues up to 264° shift by up to 8.3° and 5.0°.
#[test]
fn blues_of_deep_snow_keep_their_perceived_hue() {
    let mut rows = 0;
    for row in SNOW.lines().skip(1) {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let light = Xyz { x: cells[2], y: cells[3], z: cells[4] };
        let Mapping { oklab_shift_deg, ipt_shift_deg, kept_saturation } = map(light);
        let ipt_limit_deg = if oklab_hue_deg(light) < 264.0 { 4.0 } else { 6.0 };
        assert!(oklab_shift_deg.abs() < 5.0, "{row}: {oklab_shift_deg}");
        assert!(ipt_shift_deg.abs() < ipt_limit_deg, "{row}: {ipt_shift_deg}");
        // A mapping with exact hue keeps as little as 0.55.
        assert!(kept_saturation > 0.6, "{row}: {kept_saturation}");
        rows += 1;
    }
    assert_eq!(rows, 60);
}

/// The largest shift is that of 465 nm, which maps next to the blue primary: 11.0° in Oklab and 10.1° in IPT.
#[test]
fn monochromatic_violet_and_blue_shift_by_at_most_11_degrees() {
    for step in 0..=100 {
        let wavelength_nm = 400.0 + f64::from(step);
        let light = Observer::Cie1931.color_matching(wavelength_nm).expect("within the table");
        let Mapping { oklab_shift_deg, ipt_shift_deg, .. } = map(light);
        assert!(oklab_shift_deg.abs() < 11.1, "{wavelength_nm} nm: {oklab_shift_deg}");
        assert!(ipt_shift_deg.abs() < 10.2, "{wavelength_nm} nm: {ipt_shift_deg}");
    }
}

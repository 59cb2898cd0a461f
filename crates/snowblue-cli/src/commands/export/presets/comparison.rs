//! Snow and a preset side by side.

use snowblue_database::preset::Transmittance::{self, Below, Value};
use snowblue_database::preset::{ChannelLook, ChannelPreset, DEPTHS_CM, RendererPreset};

/// A table of three channels: snow, preset, and the error of the preset over the value of snow.
pub(super) fn lines(preset: &RendererPreset) -> Vec<String> {
    let channels = &preset.channels;
    let mut lines = vec![
        format!("{:18}{:^31}{:^31}{:^31}", "", "red", "green", "blue").trim_end().to_owned(),
        format!("{:18}", "") + &format!(" {:>10} {:>10} {:>8}", "snow", "preset", "error").repeat(3),
    ];
    lines.push(row("albedo, deep", channels, |look| Value(look.albedo)));
    for (depth, cm) in DEPTHS_CM.iter().enumerate() {
        lines.push(row(&format!("through {cm} cm"), channels, |look| look.transmittances[depth]));
    }
    lines.push(row("half radius, mm", channels, |look| Value(1e3 * look.half_radius_m)));
    lines.push(
        "Albedo: diffuse light. Through: normal incidence, black ground. Error: preset/snow - 1 in percent.".into(),
    );
    lines.push(
        "Half radius: of the circle about a narrow beam through which half of the reflected light leaves.".into(),
    );
    lines
}

fn row(name: &str, channels: &[ChannelPreset; 3], quantity: impl Fn(&ChannelLook) -> Transmittance) -> String {
    let cells = channels.iter().map(|channel| {
        let (snow, preset) = (quantity(&channel.snow), quantity(&channel.preset));
        format!(" {:>10} {:>10} {:>8}", cell(snow), cell(preset), error(snow, preset))
    });
    format!("{name:18}") + &cells.collect::<String>()
}

/// The error of the preset over the value of snow, in percent.
fn error(snow: Transmittance, preset: Transmittance) -> String {
    let percent = |preset: f64, snow: f64| format!("{:+.1}", 100.0 * (preset / snow - 1.0));
    match (snow, preset) {
        (Value(snow), Value(preset)) if snow > 0.0 => percent(preset, snow),
        (Value(snow), Below(bound)) if snow > bound => format!("<{}", percent(bound, snow)),
        // A channel of a colour outside the space is negative or 0, and has no relative error.
        _ => String::from("none"),
    }
}

/// A value with at least four significant digits, or the bound that it is below.
fn cell(transmittance: Transmittance) -> String {
    match transmittance {
        Below(bound) => format!("<{bound:.1e}"),
        Value(0.0) => String::from("0"),
        Value(value) => match value.abs() {
            magnitude if magnitude < 1e-2 => format!("{value:.3e}"),
            magnitude if magnitude < 1.0 => format!("{value:.5}"),
            _ => format!("{value:.3}"),
        },
    }
}

//! Snow and a preset side by side.

use snowblue_database::preset::{ChannelLook, ChannelPreset, DEPTHS_CM, RendererPreset};

/// A table of three channels: snow, preset, and the error of the preset over the value of snow.
pub(super) fn lines(preset: &RendererPreset) -> Vec<String> {
    let channels = &preset.channels;
    let mut lines = vec![
        format!("{:18}{:^31}{:^31}{:^31}", "", "red", "green", "blue").trim_end().to_owned(),
        format!("{:18}", "") + &format!(" {:>10} {:>10} {:>8}", "snow", "preset", "error").repeat(3),
    ];
    lines.push(row("albedo, deep", channels, |look| look.albedo));
    for (depth, cm) in DEPTHS_CM.iter().enumerate() {
        lines.push(row(&format!("through {cm} cm"), channels, |look| look.transmittances[depth]));
    }
    lines.push(row("half radius, mm", channels, |look| 1e3 * look.half_radius_m));
    lines.push(
        "Albedo: diffuse light. Through: normal incidence, black ground. Error: preset/snow - 1 in percent.".into(),
    );
    lines.push(
        "Half radius: of the circle about a narrow beam through which half of the reflected light leaves.".into(),
    );
    lines
}

fn row(name: &str, channels: &[ChannelPreset; 3], quantity: impl Fn(&ChannelLook) -> f64) -> String {
    let cells = channels.iter().map(|channel| {
        let (snow, preset) = (quantity(&channel.snow), quantity(&channel.preset));
        // A channel of a colour outside the space is negative or 0, and has no relative error.
        let error = if snow > 0.0 { format!("{:+.1}", 100.0 * (preset / snow - 1.0)) } else { String::from("none") };
        format!(" {:>10} {:>10} {error:>8}", cell(snow), cell(preset))
    });
    format!("{name:18}") + &cells.collect::<String>()
}

/// Four significant digits.
fn cell(value: f64) -> String {
    match value.abs() {
        0.0 => String::from("0"),
        magnitude if magnitude < 1e-3 => format!("{value:.3e}"),
        magnitude if magnitude < 1.0 => format!("{value:.5}"),
        _ => format!("{value:.3}"),
    }
}

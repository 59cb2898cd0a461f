//! The command line: global options and the list of commands.

use clap::{Parser, Subcommand};

use crate::commands::bake::Bake;
use crate::commands::bsdf::Bsdf;
use crate::commands::color::Color;
use crate::commands::completions::Completions;
use crate::commands::database::Database;
use crate::commands::export::Export;
use crate::commands::figures::Figures;
use crate::commands::man::Man;
use crate::commands::match_color::Match;
use crate::commands::merge::Merge;
use crate::commands::render::Render;
use crate::commands::repair::Repair;
use crate::commands::schema::Schema;
use crate::commands::sky::Sky;
use crate::commands::slab::Slab;
use crate::commands::spectrum::Spectrum;
use crate::commands::swatch::Swatch;
use crate::options::parse;

/// Predicts the blue of light through snow from what the snow is made of
#[derive(Debug, Parser)]
#[command(
    name = "snowblue",
    version,
    propagate_version = true,
    after_help = "Examples:
  snowblue spectrum --thickness 15              reflectance and transmittance of 15 cm of snow
  snowblue color --thickness 5,10,15,30         the colour of the light behind it
  snowblue render --scene block_30cm -o a.png   a picture of a scene with snow; --list-scenes lists more

'snowblue COMMAND --help' describes a command with its options, units and examples. Exit codes: 0 success, 1 failure, \
2 bad input, 130 interrupted."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Number of threads [1–1024; default: one for each core]; results do not depend on it
    #[arg(
        long, global = true, value_name = "N", value_parser = parse::whole_number::<u16>(1..=1024),
        help_heading = "Global options"
    )]
    pub(crate) threads: Option<u16>,
    /// Print results and errors only
    #[arg(long, global = true, help_heading = "Global options")]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Spectrum(Box<Spectrum>),
    Bsdf(Box<Bsdf>),
    Slab(Slab),
    Sky(Sky),
    #[command(subcommand)]
    Database(Database),
    Merge(Merge),
    Color(Box<Color>),
    Match(Box<Match>),
    Swatch(Box<Swatch>),
    Render(Render),
    Bake(Bake),
    Repair(Repair),
    #[command(subcommand)]
    Export(Export),
    Figures(Figures),
    Schema(Schema),
    Completions(Completions),
    Man(Man),
}

#[cfg(test)]
mod tests {
    use clap::error::ErrorKind;
    use clap::{Command, CommandFactory as _};
    use snowblue_transport::rng::Stream;

    use super::*;

    /// Values that are wrong for most options, and right for some.
    const VALUES: [&str; 40] = [
        "",
        " ",
        "0",
        "1",
        "-1",
        "-0",
        "400",
        "1e5",
        "1e308",
        "-1e308",
        "1e400",
        "nan",
        "inf",
        "99999999999999999999999",
        ":",
        "::",
        "1:2",
        "2:1",
        "1:2:3",
        "400:700:10",
        "0:1e9:1e-9",
        "nan:nan:nan",
        ",",
        ",,,",
        "450,550,650",
        "=",
        "black-carbon=",
        "black-carbon=1:nan",
        "=1",
        "a=b=c",
        "#ffffff",
        "#é",
        "auto",
        "diffuse",
        "0:9,0:9",
        "4294967296:0,",
        "2026-02-30T25:61:61+99:99",
        "\u{202e}\u{0}",
        "--",
        "/dev/null",
    ];

    /// The words that lead to each command, and the command.
    fn commands(path: &[String], command: &Command, found: &mut Vec<(Vec<String>, Command)>) {
        found.push((path.to_vec(), command.clone()));
        for below in command.get_subcommands() {
            commands(&[path, &[below.get_name().to_owned()]].concat(), below, found);
        }
    }

    #[test]
    fn no_command_line_makes_the_parser_panic() {
        let mut all = Vec::new();
        commands(&["snowblue".to_owned()], &Arguments::command(), &mut all);
        all.retain(|(_, command)| command.get_arguments().any(|option| option.get_long().is_some()));
        let mut random = Stream::new(1, 0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to the number of words")]
        let mut below = |end: usize| (random.uniform() * end as f64) as usize;
        let (mut right, mut wrong) = (0, 0);
        for _ in 0..300 {
            for (path, command) in &all {
                let options: Vec<&str> = command.get_arguments().filter_map(|option| option.get_long()).collect();
                let mut words = path.clone();
                for _ in 0..below(4) {
                    match below(8) {
                        0 => words.push(VALUES[below(VALUES.len())].to_owned()),
                        1 => words.push(format!("--{}", options[below(options.len())])),
                        _ => {
                            let (option, value) = (options[below(options.len())], VALUES[below(VALUES.len())]);
                            words.push(format!("--{option}={value}"));
                        }
                    }
                }
                match Arguments::try_parse_from(&words) {
                    Ok(_) => right += 1,
                    Err(_) => wrong += 1,
                }
            }
        }
        assert!(right > 100 && wrong > 1000, "{right} command lines are right, {wrong} wrong");
    }

    /// The ends of the first range in brackets of a text, and the range as it is written.
    fn limits(text: &str) -> Option<(f64, f64, &str)> {
        text.split('[').skip(1).find_map(|rest| {
            let range = rest.split([';', ']']).next()?;
            let (least, greatest) = range.split_once('–')?;
            Some((least.parse().ok()?, greatest.parse().ok()?, range))
        })
    }

    #[test]
    fn what_a_parser_refuses_lies_outside_the_limits_of_the_help() {
        let mut all = Vec::new();
        commands(&["snowblue".to_owned()], &Arguments::command(), &mut all);
        let mut refused = 0;
        for (path, command) in &all {
            for option in command.get_arguments() {
                let help = option.get_help().map(ToString::to_string).unwrap_or_default();
                let (Some(name), Some((least, greatest, range))) = (option.get_long(), limits(&help)) else { continue };
                let reason = |value: f64| {
                    let words = path.iter().cloned().chain([format!("--{name}={value}")]);
                    let error = Arguments::try_parse_from(words).err()?;
                    (error.kind() == ErrorKind::ValueValidation).then(|| error.to_string())
                };
                for end in [least, greatest] {
                    let reason = reason(end).filter(|reason| reason.contains("must"));
                    assert_eq!(reason, None, "{path:?} --{name} refuses {end}, but its help has {range}");
                }
                for beyond in [least - 1.0, greatest + 1.0] {
                    let Some(reason) = reason(beyond).filter(|reason| reason.contains("must")) else { continue };
                    let words = range.replace('–', " to ");
                    assert!(reason.contains(range) || reason.contains(&words), "{path:?} --{name}: {range}: {reason}");
                    refused += 1;
                }
            }
        }
        assert!(refused > 20, "only {refused} values were refused");
    }
}

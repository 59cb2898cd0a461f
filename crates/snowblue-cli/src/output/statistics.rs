//! Time, memory and counts of the work on a picture, as a table.

use std::fmt::Write as _;

use indicatif::HumanCount;
use snowblue_render::scene::queries::Statistics;
use snowblue_render::{FieldStatistics, SceneStatistics};

use super::phases::{Ended, Phases};

/// Widths of the names and of the values.
const WIDTHS: [usize; 2] = [42, 18];

/// The table of a picture: its phases, its scene and light field, and its samples.
pub(crate) fn statistics_table(phases: &Phases, scene: &SceneStatistics, samples: &Statistics) -> String {
    let mut table = Table(String::from("Statistics:\n"));
    table.phases(phases);
    table.scene(scene);
    if let Some(field) = &scene.light_field {
        table.field(field);
    }
    table.samples(samples);
    table.0
}

struct Table(String);

impl Table {
    fn heading(&mut self, name: &str) {
        self.line(format_args!("  {name}"));
    }

    fn line(&mut self, line: std::fmt::Arguments) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{line}");
    }

    fn value(&mut self, name: &str, value: &str) {
        let [names, values] = WIDTHS;
        self.line(format_args!("    {name:names$}{value:>values$}"));
    }

    fn count(&mut self, name: &str, count: u64) {
        self.value(name, &HumanCount(count).to_string());
    }

    /// A count, and its mean for each of `others`.
    fn count_and_mean(&mut self, name: &str, count: u64, others: u64) {
        self.count(name, count);
        if others > 0 {
            let mean = count as f64 / others as f64;
            self.0.truncate(self.0.trim_end().len());
            self.line(format_args!(" ({mean:.1} for each)"));
        }
    }

    fn phases(&mut self, phases: &Phases) {
        self.heading("Time, and greatest memory");
        let (ended, total) = phases.ended();
        for Ended { phase, time, memory_mib } in ended {
            let memory = memory_mib.map_or(String::new(), |mib| format!("{mib:11.0} MiB"));
            self.value(phase.name(), &format!("{:.2} s", time.as_secs_f64()));
            self.0.truncate(self.0.trim_end().len());
            self.line(format_args!("{memory}"));
        }
        self.value("total", &format!("{:.2} s", total.as_secs_f64()));
    }

    fn scene(&mut self, scene: &SceneStatistics) {
        self.heading("Scene");
        self.count("objects", scene.objects as u64);
        self.count("meshes", scene.meshes as u64);
        self.count("triangles", scene.triangles as u64);
    }

    fn field(&mut self, field: &FieldStatistics) {
        self.heading("Light field");
        self.count("bodies of snow", field.bodies as u64);
        self.count("cells of all bodies", field.cells as u64);
        self.count("nodes of all bodies", field.nodes as u64);
        self.value("memory of the cells and equations", &format!("{:.1} MiB", field.bytes as f64 / f64::from(1 << 20)));
        self.count("groups of four wavelengths", field.groups as u64);
        self.count("lights of one spectrum", field.lights as u64);
        self.count("solves for a body and a group", field.solves);
        self.count_and_mean("iterations", field.iterations, field.solves);
        self.count("rounds of light between bodies", field.rounds);
        self.count("rays to lights and other surfaces", field.rays);
    }

    fn samples(&mut self, samples: &Statistics) {
        self.heading("Samples");
        self.count("samples of pixels", samples.samples);
        self.count("camera rays", samples.camera_rays);
        self.count("rays from surface to surface", samples.indirect_rays);
        self.count("shadow rays", samples.shadow_rays);
        self.count("lines through snow", samples.depth_lines);
        self.count("walks into snow", samples.walks);
        self.count("walks that ended in the light field", samples.walks_into_field);
        self.count_and_mean("flights from grain to grain", samples.flights, samples.walks);
    }
}

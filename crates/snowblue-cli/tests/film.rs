//! Films: every frame has the same bits alone, in a part and in the whole film, and finished frames are kept.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Duration;

use shell::{assert_names, assert_refused, decoded, stderr};
use snowblue_render::Exposure;
use snowblue_render::film::frame_record::FrameRecord;

/// A block of snow and two lamps of different spectra, of which the first is dark at first.
const SCENE: &str = "[camera]\nposition = [0.3, -1, 0.4]\nlook_at = [0, 0, 0]\nvertical_fov_deg = 25\n\
    [film]\nwidth = 12\nheight = 8\n\
    [integrator]\nsamples_per_pixel = 4\ntype = \"diffusion\"\nmax_bounces = 0\n[light_field]\nstep_mm = 20\n\
    [material.snow]\ntype = \"pca_snow\"\ngrain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n\
    [[light]]\ntype = \"point\"\nposition = [0, 0.4, 0.1]\nradiant_intensity_w_sr = 10\n\
    [[light]]\ntype = \"point\"\nposition = [0.4, -0.4, 0.1]\nradiant_intensity_w_sr = 2\nilluminant = \"A\"\n\
    [[object]]\nshape = \"box\"\nsize = [0.3, 0.1, 0.2]\nmaterial = \"snow\"\n[keyframes]\n";
const CAMERA: &str = "camera.position = [[0.3, -1, 0.4], [-0.3, -1, 0.4]]\n";
const LAMP: &str = "light.0.radiant_intensity_w_sr = [0, 10]\n";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new(keyframes: &str) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        std::fs::write(folder.path("scene.toml"), format!("{SCENE}{keyframes}")).unwrap();
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn arguments(&self, output: &str, more: &[&str]) -> Vec<String> {
        let [scene, output] = ["scene.toml", output].map(|name| self.path(name).to_str().unwrap().to_owned());
        let mut arguments = ["render".to_owned(), scene, "-o".to_owned(), output].to_vec();
        arguments.extend(more.iter().map(|word| (*word).to_owned()));
        arguments
    }

    /// Renders, and returns what was printed.
    fn render(&self, output: &str, more: &[&str]) -> String {
        let arguments = self.arguments(output, more);
        stderr(&arguments.iter().map(|word| &**word).collect::<Vec<_>>())
    }

    fn assert_refused(&self, output: &str, more: &[&str], expected: &[&str]) {
        let arguments = self.arguments(output, more);
        assert_refused(&arguments.iter().map(|word| &**word).collect::<Vec<_>>(), expected);
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    fn record(&self, name: &str) -> FrameRecord {
        FrameRecord::read(&self.path(name)).unwrap()
    }

    /// Asserts that films of three frames have the same bytes.
    fn assert_same_films(&self, one: &str, other: &str) {
        for number in ["0000", "0001", "0002"] {
            let [one, other] = [one, other].map(|name| self.bytes(&name.replace("{}", number)));
            assert!(one == other, "{number}");
        }
    }
}

#[test]
fn a_frame_is_the_same_alone_and_in_a_film() {
    let folder = Folder::new(&format!("{CAMERA}{LAMP}"));
    let printed = folder.render("whole_{}.exr", &["--frames", "3"]);
    // The first lamp is dark in the first frame, and the second does not change.
    assert_names(&printed, &["whole_0000.exr: 1 light field solved", "whole_0002.exr: 1 light field solved"]);
    let part = ["--frames", "3", "--frame-range"];
    folder.render("part_{}.exr", &[&part[..], &["1:3"]].concat());
    folder.render("part_{}.exr", &[&part[..], &["0:1", "--threads", "1"]].concat());
    folder.assert_same_films("whole_{}.exr", "part_{}.exr");
    assert!(!folder.path("part_0003.exr").exists());
    assert!(folder.bytes("whole_0000.exr") != folder.bytes("whole_0001.exr"));
    // A picture without --frames is the first frame; it says less of itself.
    folder.render("still.exr", &["--keep-sums"]);
    folder.render("kept_{}.exr", &["--frames", "3", "--frame-range", "0:1", "--keep-sums", "--exposure", "0"]);
    let slim = |name: &str| {
        let [part, slim] = [name, "slim.exr"].map(|name| folder.path(name).to_str().unwrap().to_owned());
        stderr(&["merge", &part, "-o", &slim]);
        folder.bytes("slim.exr")
    };
    assert!(slim("still.exr") == slim("kept_0000.exr"));
}

#[test]
fn only_a_camera_that_moves_solves_for_no_light() {
    let folder = Folder::new(CAMERA);
    let printed = folder.render("film_{}.png", &["--frames", "3", "--exposure", "0"]);
    let solved: Vec<&str> = printed.lines().map(|line| line.rsplit_once(": ").unwrap().1).collect();
    assert_eq!(solved, ["2 light fields solved", "0 light fields solved", "0 light fields solved"]);
    let printed = folder.render("slab_{}.png", &["--frames", "2", "--exposure", "0", "--integrator", "pcasnow"]);
    assert_eq!(printed, "", "no light field");
}

#[test]
fn finished_frames_are_kept_and_others_refused() {
    let folder = Folder::new(LAMP);
    let film = ["--frames", "3", "--noise-target", "0.1", "--resume"];
    folder.render("whole_{}.png", &film);
    folder.render("film_{}.png", &[&film[..], &["--frame-range", "1:2"]].concat());
    let before = std::fs::metadata(folder.path("film_0001.png")).unwrap().modified().unwrap();
    let printed = folder.render("film_{}.png", &film);
    assert_names(&printed, &["1 of 3 frames are finished", "film_0000.png", "film_0002.png"]);
    assert!(!printed.contains("film_0001.png"), "{printed}");
    assert_eq!(std::fs::metadata(folder.path("film_0001.png")).unwrap().modified().unwrap(), before);
    folder.assert_same_films("whole_{}.png", "film_{}.png");
    let again = folder.render("film_{}.png", &film);
    let lines: Vec<&str> = again.lines().collect();
    assert!(lines.len() == 2 && lines[0].starts_with("exposure: "), "{again}");
    assert_eq!(lines[1], "3 of 3 frames are finished");
    // All have the exposure of the brightest.
    let exposures = ["0000", "0001", "0002"].map(|number| folder.record(&format!("film_{number}.png")).exposure);
    assert!(matches!(exposures[0], Exposure::Stops(_)) && exposures[1..].iter().all(|one| *one == exposures[0]));
    folder.render("bright_{}.png", &["--frames", "3", "--frame-range", "2:3"]);
    assert_eq!(folder.record("bright_0002.png").exposure, exposures[0]);
    let [dark, bright] = ["film_0000.png", "film_0002.png"].map(|name| greatest(&folder.bytes(name)));
    assert!(dark < bright && bright > 200, "{dark} {bright}");
    // What belongs to another film is not touched.
    for (more, expected) in [
        (vec!["--frames", "4"], &["film_0001.png", "another picture", "scene"][..]),
        (vec!["--frames", "3", "--seed", "9"], &["film_0000.png", "seed is 1 in one and 9"]),
    ] {
        folder.assert_refused("film_{}.png", &[&more[..], &["--noise-target", "0.1", "--resume"]].concat(), expected);
    }
    // So are frames of another exposure, whether or not a frame is missing.
    let bright = [&film[..], &["--exposure", "3"]].concat();
    let expected = ["film_0000.png: cannot be resumed", "exposure is", "not 3"];
    folder.assert_refused("film_{}.png", &bright, &expected);
    folder.render("other_{}.png", &bright);
    assert_eq!(folder.render("other_{}.png", &bright).trim(), "3 of 3 frames are finished");
    let automatic = [&film[..], &["--exposure", "auto", "--quiet"]].concat();
    folder.assert_refused("other_{}.png", &automatic, &["other_0000.png: cannot be resumed", "exposure is 3, not"]);
    std::fs::remove_file(folder.path("film_0001.png")).unwrap();
    folder.assert_refused("film_{}.png", &[&bright[..], &["--quiet"]].concat(), &expected);
    std::fs::write(folder.path("film_0001.png"), "no picture").unwrap();
    folder.assert_refused("film_{}.png", &film, &["film_0001.png", "no frame of a film"]);
    // An EXR with a noise target, and with AOVs.
    let aovs = ["--aovs", "normal"];
    folder.render("film_{}.exr", &[&film[..], &aovs].concat());
    assert_eq!(folder.render("film_{}.exr", &[&film[..], &aovs].concat()).trim(), "3 of 3 frames are finished");
    folder.assert_refused("film_{}.exr", &film, &["film_0000.exr", "AOVs"]);
}

/// The greatest channel of a PNG.
fn greatest(png: &[u8]) -> u8 {
    decoded(png).1.into_iter().max().unwrap()
}

/// A film is stopped in its second frame, by a signal that lets it save its samples and by one that does not.
#[cfg(unix)]
#[test]
fn a_film_that_was_stopped_is_resumed_to_the_same_bits() {
    // The first frame has few samples, the second more than any machine renders within the test.
    let samples = "integrator.samples_per_pixel = { at = [0, 0.5, 0.5, 1], values = [3, 3, 16000000, 16000000] }\n";
    let folder = Folder::new(&format!("{CAMERA}{samples}"));
    let started = |output: &str| {
        let more = ["--frames", "3", "--checkpoint", "0.01", "--resume", "--threads", "1"];
        Command::new(env!("CARGO_BIN_EXE_snowblue"))
            .args(folder.arguments(output, &more))
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    for (signal, output) in [("-INT", "int_{}.exr"), ("-KILL", "kill_{}.exr")] {
        let [first, second] = ["0000", "0001"].map(|number| output.replace("{}", number));
        let mut child = started(output);
        while !folder.path(&second).exists() {
            assert!(child.try_wait().unwrap().is_none(), "the film ended before its first checkpoint");
            std::thread::sleep(Duration::from_millis(20));
        }
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        let ended = child.wait_with_output().unwrap();
        if signal == "-INT" {
            let message = String::from_utf8(ended.stderr).unwrap();
            assert_eq!(ended.status.code(), Some(130), "{message}");
            assert_names(&message, &["interrupted at frame 1", "--resume"]);
        }
        // As many samples as there are and some more, the same in all frames.
        let blocks = folder.record(&second).coverage;
        let most = blocks.blocks().iter().map(|block| block.samples.end).max().unwrap();
        let spp = (most + 20).to_string();
        assert!(most > 3, "{most}");
        std::fs::remove_file(folder.path(&first)).unwrap();
        let printed = folder.render(output, &["--frames", "3", "--spp", &spp, "--resume"]);
        assert_names(&printed, &[&first, &second]);
        folder.render("whole_{}.exr", &["--frames", "3", "--spp", &spp]);
        folder.assert_same_films(output, "whole_{}.exr");
    }
}

#[test]
fn what_makes_no_film_is_refused_in_one_line() {
    let folder = Folder::new(CAMERA);
    let cases = [
        ("film.png", vec!["--frames", "3"], &["film.png", "must contain {}"][..]),
        ("film_{}.jpg", vec!["--frames", "3"], &["film_0000.jpg", ".png or .exr"]),
        ("no/film_{}.png", vec!["--frames", "3"], &["no/film_0000.png", "folder does not exist"]),
        ("film_{}.png", vec!["--frames", "1"], &["--frames", "1"]),
        ("film_{}.png", vec!["--frame-range", "0:1"], &["{} stands for the number of a frame: give --frames N"]),
        ("film_{}.png", vec![], &["film_{}.png: {} stands for the number of a frame: give --frames N"]),
        ("film.png", vec!["--frame-range", "0:1"], &["--frame-range has no effect", "--frames N"]),
        ("film_{}.png", vec!["--frames", "3", "--frame-range", "1:4"], &["--frame-range ends at 4", "3 frames"]),
        ("film_{}.png", vec!["--frames", "3", "--aovs", "normal"], &["--aovs", ".exr"]),
        ("film_{}.png", vec!["--frames", "3", "--width", "0"], &["--width", "'0'", "1–16384"]),
        ("film_{}.exr", vec!["--frames", "3", "--crop", "0:40,0:2"], &["--crop ends at 40,2"]),
        ("film_{}.png", vec!["--frames", "3", "--check"], &["--check"]),
    ];
    for (output, more, expected) in cases {
        folder.assert_refused(output, &more, expected);
    }
    // A value that is out of range late in the film is found before the first frame.
    let late = Folder::new("camera.vertical_fov_deg = { at = [0, 0.9, 1], values = [20, 30, 300] }\n");
    late.assert_refused("film_{}.png", &["--frames", "20"], &["scene.toml:33", "camera.vertical_fov_deg is 300 deg"]);
    let still = Folder::new("");
    still.assert_refused("film_{}.png", &["--frames", "20"], &["scene.toml", "no [keyframes]"]);
    for folder in [folder, late, still] {
        assert_eq!(std::fs::read_dir(folder.0.path()).unwrap().count(), 1, "nothing was written");
    }
}

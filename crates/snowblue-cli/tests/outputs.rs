//! Where results go: files, links, pipes and devices, and the checks before the work.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test")]

mod shell;

use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};

use shell::{assert_refused, decoded, shipped_scene, snowblue, stdout};

const SPECTRUM: [&str; 3] = ["spectrum", "--grain-size", "400"];

/// Renders a small picture.
fn render(output: &str, more: &[&str]) -> std::process::Output {
    let scene = shipped_scene("block_30cm.toml").display().to_string();
    let small = ["--width", "6", "--height", "4", "--spp", "2", "--integrator", "pcasnow"];
    snowblue(&[&["render", &*scene, "--quiet", "-o", output], &small[..], more].concat())
}

#[test]
fn a_dash_is_the_standard_output() {
    for (more, start) in [(&["-o", "-"][..], "thickness_cm,"), (&["-o", "-", "--format", "json"], "{")] {
        let text = stdout(&[&SPECTRUM[..], more].concat());
        assert!(text.starts_with(start), "{more:?}: {text}");
        assert_eq!(text, stdout(&[&SPECTRUM[..], &more[2..]].concat()));
    }
    for output in ["-", "/dev/stdout"] {
        let picture = render(output, &[]);
        assert_eq!(decoded(&picture.stdout).0, 6, "{output}: {}", String::from_utf8_lossy(&picture.stderr));
    }
    let scene = shipped_scene("block_30cm.toml").display().to_string();
    assert_refused(&["render", &scene, "-o", "-", "--checkpoint", "1"], &["--checkpoint", "file"]);
}

/// What another program appends to the same file stays.
#[test]
fn the_standard_output_may_be_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("both.txt");
    let script = format!("{{ \"$0\" {} -o /dev/stdout --quiet; echo end; }} > \"$1\"", SPECTRUM.join(" "));
    let shell = Command::new("sh").args(["-c", &script, env!("CARGO_BIN_EXE_snowblue")]).arg(&file).status().unwrap();
    assert!(shell.success());
    let text = std::fs::read_to_string(file).unwrap();
    assert_eq!(text.strip_suffix("end\n"), Some(&*stdout(&SPECTRUM)));
}

#[test]
fn pipes_and_devices_are_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe").display().to_string();
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = Command::new("cat").arg(&pipe).stdout(Stdio::piped()).spawn().unwrap();
    assert!(render(&pipe, &[]).status.success());
    assert_eq!(decoded(&reader.wait_with_output().unwrap().stdout).0, 6);
    assert_eq!(render("/dev/null", &[]).status.code(), Some(0));
    let full = render("/dev/full", &[]);
    let message = String::from_utf8_lossy(&full.stderr).into_owned();
    assert!(full.status.code() == Some(1) && message.contains("No space"), "{message}");
    for arguments in [&["spectrum", "--quiet"][..], &["--help"], &["render", "--list-scenes"]] {
        let device = std::fs::File::create("/dev/full").unwrap();
        let full = Command::new(env!("CARGO_BIN_EXE_snowblue")).args(arguments).stdout(device).output().unwrap();
        let message = String::from_utf8_lossy(&full.stderr).into_owned();
        assert_eq!(full.status.code(), Some(1), "{message}");
        assert!(message.starts_with("snowblue: the standard output cannot be written: No space"), "{message}");
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(left.len(), 1, "{left:?}");
}

#[test]
fn a_link_stays_and_its_file_changes() {
    let folder = tempfile::tempdir().unwrap();
    let [file, link] = ["file.png", "link.png"].map(|name| folder.path().join(name));
    symlink("file.png", &link).unwrap();
    assert!(render(link.to_str().unwrap(), &[]).status.success());
    assert!(link.is_symlink() && !file.is_symlink());
    assert_eq!(decoded(&std::fs::read(file).unwrap()).0, 6);
}

/// Each of these works would take longer than the test may.
#[test]
fn outputs_are_checked_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let long = ["spectrum", "--grain-size", "400", "--engine", "montecarlo", "--rays", "1000000000"];
    assert_refused(&[&long[..], &["-o", &at("spectrum.xyz")]].concat(), &["spectrum.xyz", ".csv", "--format"]);
    assert_refused(&[&long[..], &["-o", &at("missing/a.csv")]].concat(), &["missing/a.csv: its folder does not exist"]);
    assert_refused(&[&long[..], &["-o", &at(""), "--format", "csv"]].concat(), &["is a folder"]);
    let closed = at("a.csv");
    std::fs::write(at("b"), "").unwrap();
    assert_refused(&[&long[..], &["-o", &at("b/a.csv")]].concat(), &["b/a.csv: its folder is a file"]);
    symlink(at("b/c"), &closed).unwrap();
    assert_refused(&[&long[..], &["-o", &closed]].concat(), &["a.csv", "cannot be written"]);
}

#[test]
fn merge_does_not_overwrite_its_parts() {
    let folder = tempfile::tempdir().unwrap();
    let part = folder.path().join("part.exr").display().to_string();
    assert!(render(&part, &["--keep-sums"]).status.success());
    let before = std::fs::read(&part).unwrap();
    assert_refused(&["merge", &part, "-o", &part], &["part.exr", "overwritten"]);
    assert!(std::fs::read(Path::new(&part)).unwrap() == before);
}

#[test]
fn a_picture_that_needs_too_much_memory_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("large.exr").display().to_string();
    let scene = shipped_scene("block_30cm.toml").display().to_string();
    let large = ["render", &scene, "-o", &picture, "--width", "16384", "--height", "16384", "--spp", "1"];
    let large = [&large[..], &["--integrator", "pcasnow"]].concat();
    // 36 sums of 16 bytes for each pixel, and 4 for the number of its samples.
    let spectra = [&large[..], &["--aovs", "rgb,spectrum"]].concat();
    assert_refused(&spectra, &["large.exr", "148480 MiB", "16384 MiB", "--film-memory-mib", "--crop"]);
    let more = [&large[..], &["--film-memory-mib", "21503"]].concat();
    assert_refused(&more, &["21504 MiB", "21503 MiB"]);
    assert!(snowblue(&[&spectra[..], &["--crop", "0:4,0:4"]].concat()).status.success());
    // The window of both corners is the whole picture; the sums of the first are in memory too.
    let corner = [&spectra[..], &["--crop", "16380:16384,16380:16384", "--resume"]].concat();
    assert_refused(&corner, &["large.exr", "148481 MiB", "16384 MiB"]);
}

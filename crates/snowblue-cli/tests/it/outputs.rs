//! Where results go: files, links, pipes and devices, and the checks before the work.

use std::os::unix::fs::symlink;
use std::process::{Command, Output, Stdio};

use crate::shell::{Folder, command, decoded, stdout};

const SPECTRUM: &str = "spectrum --wavelengths 500";

/// Renders a small picture.
fn render(folder: &Folder, output: &str) -> Output {
    let small = "--width 6 --height 4 --spp 2 --integrator pcasnow";
    folder.run(&format!("render --scene block_30cm --quiet {small} -o {output}"))
}

#[test]
fn a_dash_is_the_standard_output() {
    for (format, start) in [("", "thickness_cm,"), ("--format json", "{")] {
        let text = stdout(&format!("{SPECTRUM} -o - {format}"));
        assert!(text.starts_with(start), "{format}: {text}");
        assert_eq!(text, stdout(&format!("{SPECTRUM} {format}")));
    }
    let folder = Folder::new();
    for output in ["-", "/dev/stdout"] {
        let picture = render(&folder, output);
        assert_eq!(decoded(&picture.stdout).0, 6, "{output}: {}", String::from_utf8_lossy(&picture.stderr));
    }
}

/// What another program appends to the same file stays.
#[test]
fn the_standard_output_may_be_a_file() {
    let folder = Folder::new();
    let script = format!("{{ \"$0\" {SPECTRUM} -o /dev/stdout --quiet; echo end; }} > both.txt");
    let mut shell = Command::new("sh");
    shell.args(["-c", &script, env!("CARGO_BIN_EXE_snowblue")]).current_dir(folder.path(""));
    assert!(shell.status().unwrap().success());
    assert_eq!(folder.text("both.txt").strip_suffix("end\n"), Some(&*stdout(SPECTRUM)));
}

#[test]
fn pipes_and_devices_are_not_replaced() {
    let folder = Folder::new();
    let pipe = folder.path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = Command::new("cat").arg(&pipe).stdout(Stdio::piped()).spawn().unwrap();
    assert!(render(&folder, "pipe").status.success());
    assert_eq!(decoded(&reader.wait_with_output().unwrap().stdout).0, 6);
    assert_eq!(render(&folder, "/dev/null").status.code(), Some(0));
    let full = render(&folder, "/dev/full");
    let message = String::from_utf8_lossy(&full.stderr).into_owned();
    assert!(full.status.code() == Some(1) && message.contains("No space"), "{message}");
    for line in ["spectrum --wavelengths 500 --quiet", "--help", "render --list-scenes"] {
        let device = std::fs::File::create("/dev/full").unwrap();
        let full = command(line).stdout(device).output().unwrap();
        let message = String::from_utf8_lossy(&full.stderr).into_owned();
        assert_eq!(full.status.code(), Some(1), "{message}");
        assert!(message.starts_with("snowblue: the standard output cannot be written: No space"), "{message}");
    }
    let left: Vec<_> = std::fs::read_dir(folder.path("")).unwrap().collect();
    assert_eq!(left.len(), 1, "{left:?}");
}

#[test]
fn a_link_stays_and_its_file_changes() {
    let folder = Folder::new();
    let [file, link] = ["file.png", "link.png"].map(|name| folder.path(name));
    symlink("file.png", &link).unwrap();
    assert!(render(&folder, "link.png").status.success());
    assert!(link.is_symlink() && !file.is_symlink());
    assert_eq!(decoded(&std::fs::read(file).unwrap()).0, 6);
}

/// The work would take longer than a test may.
#[test]
fn a_link_into_a_file_is_refused_before_the_work() {
    let folder = Folder::new();
    folder.write("b", "");
    symlink(folder.path("b/c"), folder.path("a.csv")).unwrap();
    let long = "spectrum --grain-size 400 --engine montecarlo --rays 1000000000 -o a.csv";
    folder.assert_refused(long, &["a.csv", "cannot be written"]);
}

#[test]
fn a_picture_that_needs_too_much_memory_is_refused_before_the_work() {
    let folder = Folder::new();
    let large = "render --scene block_30cm --integrator pcasnow -o large.exr --width 16384 --height 16384 --spp 1";
    // 36 sums of 16 bytes for each pixel, and 4 for the number of its samples.
    let spectra = format!("{large} --aovs rgb,spectrum");
    folder.assert_refused(&spectra, &["large.exr", "148480 MiB", "16384 MiB", "--film-memory-mib", "--crop"]);
    folder.assert_refused(&format!("{large} --film-memory-mib 21503"), &["21504 MiB", "21503 MiB"]);
    folder.stdout(&format!("{spectra} --crop 0:4,0:4"));
    // The window of both corners is the whole picture; the sums of the first are in memory too.
    let corner = format!("{spectra} --crop 16380:16384,16380:16384 --resume");
    folder.assert_refused(&corner, &["large.exr", "148481 MiB", "16384 MiB"]);
}

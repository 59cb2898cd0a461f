//! An interrupt before the first sample.

use std::io::Read as _;
use std::net::TcpListener;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::shell::{Folder, command};

const INTERRUPT: u64 = 2;

/// Whether a process has a handler for interrupts (proc(5): the mask SigCgt).
fn handles_interrupts(process: &Child) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{}/status", process.id())).unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap() & 1 << (INTERRUPT - 1) != 0
}

/// Starts a command in a folder, waits until it is ready, and interrupts it. The command must end without samples.
fn interrupt_before_samples(folder: &Folder, line: &str, is_ready: impl Fn(&Child) -> bool) {
    let mut process = command(line).current_dir(folder.path("")).stderr(Stdio::piped()).spawn().unwrap();
    while !is_ready(&process) {
        assert!(process.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent = Command::new("kill").args(["-INT", &process.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let output = process.wait_with_output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert_eq!(message, "snowblue: interrupted: nothing is written\n");
}

/// The light field of this scene takes many seconds, whose length a test cannot measure: what it sees is that no sample
/// was written.
#[test]
fn an_interrupt_before_the_first_sample_leaves_nothing() {
    let folder = Folder::new();
    for line in ["render --scene hole_and_footprint -o picture.exr", "bake --scene hole_and_footprint -o snow.glb"] {
        interrupt_before_samples(&folder, line, handles_interrupts);
        assert!(folder.files().is_empty());
    }
}

#[test]
fn a_first_picture_is_a_whole_png_and_goes_with_an_interrupt() {
    let folder = Folder::new();
    let seen = std::cell::Cell::new(false);
    interrupt_before_samples(&folder, "render --scene hole_and_footprint -o picture.png", |_| {
        let picture = std::fs::read(folder.path("picture.png")).unwrap_or_default();
        seen.set(
            picture.windows(13).any(|text| text == b"First picture") && picture.ends_with(b"IEND\xae\x42\x60\x82"),
        );
        seen.get()
    });
    assert!(seen.get() && folder.files().is_empty());
    // An earlier file stays until there are samples, also when the viewer gets a first picture.
    folder.write("picture.png", "an earlier picture");
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let viewer = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        // The second packet has the pixels.
        for _ in 0..2 {
            let mut length = [0; 4];
            stream.read_exact(&mut length).unwrap();
            let mut packet = vec![0; u32::from_le_bytes(length) as usize - length.len()];
            stream.read_exact(&mut packet).unwrap();
        }
    });
    let line = format!("render --scene hole_and_footprint --tev {address} -o picture.png");
    interrupt_before_samples(&folder, &line, |_| viewer.is_finished());
    assert_eq!(folder.bytes("picture.png"), b"an earlier picture");
}

//! Pictures made in parts, interrupted and resumed, are the picture to the last bit; parts of others are refused.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::io::Read as _;
use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use shell::{refused, snowblue, stdout};

/// A small picture of the block that ships, in a folder of its own.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/block_30cm.toml");
        std::fs::copy(shipped, folder.path().join("scene.toml")).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    /// The arguments of a rendering of 21 × 14 pixels.
    fn rendering(&self, output: &str, more: &[&str]) -> Vec<String> {
        let mut arguments = ["render", &self.path("scene.toml"), "-o", &self.path(output)].map(str::to_owned).to_vec();
        for (option, value) in [("--width", "21"), ("--height", "14")] {
            if !more.contains(&option) {
                arguments.extend([option.to_owned(), value.to_owned()]);
            }
        }
        arguments.extend(more.iter().map(|word| (*word).to_owned()));
        arguments
    }

    fn render(&self, output: &str, more: &[&str]) -> Vec<u8> {
        stdout(&words(&self.rendering(output, more)));
        self.bytes(output)
    }

    fn refused(&self, output: &str, more: &[&str]) -> String {
        refused(&words(&self.rendering(output, more)))
    }

    fn merge(&self, parts: &[&str], output: &str, more: &[&str]) -> Vec<u8> {
        stdout(&words(&self.merging(parts, output, more)));
        self.bytes(output)
    }

    fn merging(&self, parts: &[&str], output: &str, more: &[&str]) -> Vec<String> {
        let mut arguments = vec!["merge".to_owned()];
        arguments.extend(parts.iter().map(|part| self.path(part)));
        arguments.extend(["-o".to_owned(), self.path(output)]);
        arguments.extend(more.iter().map(|word| (*word).to_owned()));
        arguments
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    fn names(&self) -> usize {
        std::fs::read_dir(self.0.path()).unwrap().count()
    }
}

fn words(arguments: &[String]) -> Vec<&str> {
    arguments.iter().map(|word| &**word).collect()
}

/// The pixels of a PNG.
fn shown(png: &[u8]) -> Vec<u8> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels
}

/// The pixels of all channels of a picture, as bits.
fn pixels(path: &str) -> Vec<(String, Vec<u32>)> {
    use exr::prelude::{ReadChannels as _, ReadLayers as _, Sample};
    let image = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let list = image.all_attributes().from_file(path).unwrap().layer_data.channel_data.list;
    let bits = |sample: Sample| match sample {
        Sample::U32(bits) => bits,
        other => other.to_f32().to_bits(),
    };
    list.iter().map(|channel| (channel.name.to_string(), channel.sample_data.values().map(bits).collect())).collect()
}

#[test]
fn parts_are_merged_to_the_whole() {
    let place = Place::new();
    place.render("whole.exr", &["--spp", "10"]);
    let whole = pixels(&place.path("whole.exr"));
    assert_eq!(whole.len(), 3, "a finished picture has colours only");
    place.render("a.exr", &["--spp-range", "0:3"]);
    place.render("b.exr", &["--spp-range", "3:10", "--crop", "0:8,0:14", "--threads", "1"]);
    place.render("c.exr", &["--spp-range", "3:10", "--crop", "8:21,0:5", "--threads", "3"]);
    place.render("d.exr", &["--spp-range", "3:10", "--crop", "8:21,5:14"]);
    let parts = ["d.exr", "a.exr", "c.exr", "b.exr"];
    place.merge(&parts, "merged.exr", &[]);
    assert_eq!(pixels(&place.path("merged.exr")), whole);
    // A merged part is a part.
    place.merge(&["b.exr", "d.exr", "c.exr"], "most.exr", &["--keep-sums"]);
    place.merge(&["most.exr", "a.exr"], "merged.exr", &[]);
    assert_eq!(pixels(&place.path("merged.exr")), whole);
    // The part has its place in the picture, and its pixel is the picture's.
    place.render("pixel.exr", &["--spp", "10", "--crop", "17:18,5:6"]);
    for ((name, all), (part, one)) in whole.iter().zip(pixels(&place.path("pixel.exr"))) {
        assert_eq!((name, all[5 * 21 + 17]), (&part, one[0]));
    }
    // As PNG too, in the brightness that the scene asks for, or another.
    let bright = shown(&place.render("whole.png", &["--spp", "10"]));
    assert!(bright == shown(&place.merge(&parts, "merged.png", &[])));
    assert!(bright != shown(&place.merge(&parts, "merged.png", &["--exposure", "1"])));
    place.merge(&parts, "merged.exr", &["--keep-sums"]);
    assert!(bright == shown(&place.merge(&["merged.exr"], "merged.png", &[])), "through another file");
    place.render("dark.exr", &["--spp-range", "10:12", "--exposure", "-5"]);
    place.merge(&["a.exr", "dark.exr"], "merged.exr", &[]);
    let message = refused(&words(&place.merging(&["a.exr", "dark.exr"], "merged.png", &[])));
    assert!(message.contains("a.exr is for an exposure of -1.2") && message.contains("of -5: give --exposure"));
}

#[test]
fn parts_that_do_not_fit_are_refused_in_one_line() {
    let place = Place::new();
    place.render("a.exr", &["--spp-range", "0:4"]);
    place.render("b.exr", &["--spp-range", "3:6"]);
    place.render("seed.exr", &["--spp-range", "4:6", "--seed", "7"]);
    place.render("view.exr", &["--spp-range", "4:6", "--path", "view"]);
    place.render("size.exr", &["--spp-range", "4:6", "--width", "22"]);
    place.render("normal.exr", &["--spp-range", "4:6", "--channels", "rgb,normal"]);
    place.render("tile.exr", &["--spp", "4", "--crop", "0:2,0:2"]);
    place.render("corner.exr", &["--spp", "4", "--crop", "3:5,3:5"]);
    place.render("plain.exr", &["--spp", "1"]);
    let scene = std::fs::read_to_string(place.path("scene.toml")).unwrap();
    std::fs::write(place.path("scene.toml"), format!("{scene}\n# another\n")).unwrap();
    place.render("scene.exr", &["--spp-range", "4:6"]);
    let refusals = [
        (["a.exr", "b.exr"], "both have sample 3 of pixel 0,0"),
        (["a.exr", "seed.exr"], "are not of one picture: seed is 1 in one and 7 in the other"),
        (["a.exr", "view.exr"], "path is scene's in one and view in the other"),
        (["a.exr", "size.exr"], "width is 21 in one and 22 in the other"),
        (["a.exr", "normal.exr"], "tell different things: rgb, and rgb,normal"),
        (["a.exr", "scene.exr"], "not of one picture: the scene, or a file that it names, has another content"),
        (["tile.exr", "corner.exr"], "no part has a sample of pixel 2,0"),
        (["a.exr", "plain.exr"], "plain.exr: the picture has no sums to go on from (render with --keep-sums)"),
        (["a.exr", "scene.toml"], "only parts of one kind"),
        (["a.exr", "missing.exr"], "missing.exr"),
    ];
    let before = place.names();
    for (parts, expected) in refusals {
        let message = refused(&words(&place.merging(&parts, "no.exr", &[])));
        assert!(message.contains(expected), "{message}");
    }
    for (more, expected) in [
        (vec!["--crop", "0:22,0:14"], "--crop ends at 22,14, but the picture has 21 × 14 pixels"),
        (vec!["--crop", "5:5,0:1"], "'5:5' is not a range A:B"),
        (vec!["--spp-range", "0:4294967296"], "is not a range A:B of whole numbers with 0 ≤ A < B ≤ 4294967295"),
        (vec!["--spp-range", "0:4", "--spp", "4"], "cannot be used with"),
        (vec!["--channels", "depth"], "'depth' is none of rgb, spectrum"),
        (vec!["--checkpoint", "0"], "0 minutes"),
    ] {
        let message = place.refused("no.exr", &more);
        assert!(message.contains(expected), "{message}");
    }
    for option in [vec!["--resume"], vec!["--keep-sums"], vec!["--channels", "albedo"]] {
        let message = place.refused("no.png", &option);
        assert!(message.contains(option[0]) && message.contains("needs an .exr"), "{message}");
    }
    assert_eq!(place.names(), before, "nothing was written");
}

#[test]
fn a_picture_is_resumed_to_more_samples() {
    let place = Place::new();
    place.render("whole.exr", &["--spp", "11", "--keep-sums"]);
    let whole = pixels(&place.path("whole.exr"));
    for samples in ["4", "11", "11"] {
        place.render("grown.exr", &["--spp", samples, "--resume"]);
    }
    assert!(pixels(&place.path("grown.exr")) == whole);
    let before = place.bytes("grown.exr");
    let message = place.refused("grown.exr", &["--spp", "20", "--resume", "--seed", "3"]);
    assert!(message.contains("grown.exr: cannot be resumed: the picture is another; seed is 1"), "{message}");
    assert!(place.bytes("grown.exr") == before, "nothing was written");
    // A detail first, then the rest around it.
    place.render("detail.exr", &["--spp", "11", "--crop", "3:9,4:8", "--resume"]);
    place.render("detail.exr", &["--spp", "11", "--resume"]);
    assert!(pixels(&place.path("detail.exr")) == whole);
}

/// Starts a rendering that takes minutes on the fastest of machines, and sends it a signal when it works.
#[cfg(unix)]
fn interrupted(place: &Place, output: &str, signal: &str) -> (Option<i32>, String) {
    let arguments = place.rendering(output, &["--spp", MOST_SAMPLES, "--checkpoint", "0.01"]);
    let mut child =
        Command::new(env!("CARGO_BIN_EXE_snowblue")).args(&arguments).stderr(Stdio::piped()).spawn().unwrap();
    // The first checkpoint says that it works.
    let start = Instant::now();
    while !Path::new(&place.path(output)).exists() {
        assert_eq!(child.try_wait().unwrap(), None, "it ended before it was asked to");
        if start.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("no checkpoint in a minute");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let status = child.wait().unwrap();
    let mut message = String::new();
    child.stderr.take().unwrap().read_to_string(&mut message).unwrap();
    (status.code(), message)
}

#[cfg(unix)]
const MOST_SAMPLES: &str = "16777216";

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_a_picture_that_can_be_resumed() {
    let place = Place::new();
    for signal in ["-INT", "-TERM"] {
        let (code, message) = interrupted(&place, "stopped.exr", signal);
        assert_eq!(code, Some(130), "{message}");
        let how_to_go_on = format!(" of {MOST_SAMPLES} samples per pixel; the same command with --resume goes on");
        assert!(message.contains(&how_to_go_on), "{message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert_eq!(place.names(), 2, "the scene and the picture");
        std::fs::remove_file(place.path("stopped.exr")).unwrap();
    }
    // Without a moment to write anything, the last checkpoint remains, and is one to go on from.
    assert_eq!(interrupted(&place, "killed.exr", "-KILL").0, None);
    place.render("killed.exr", &["--spp", "1", "--resume"]);
    // Some pixels have a pass more than others.
    let (_, message) = interrupted(&place, "stopped.exr", "-INT");
    let (samples, _) = message.split_once(" of ").unwrap();
    let most: u32 = samples.rsplit_once([' ', '–']).unwrap().1.parse().unwrap();
    let beyond = (most + 50).to_string();
    place.render("whole.exr", &["--spp", &beyond, "--keep-sums"]);
    place.render("stopped.exr", &["--spp", &beyond, "--resume"]);
    assert!(pixels(&place.path("stopped.exr")) == pixels(&place.path("whole.exr")), "{message}");
    let (code, message) = interrupted(&place, "stopped.png", "-INT");
    assert!(code == Some(130) && message.contains("a PNG cannot be resumed, an .exr can"), "{message}");
}

#[test]
fn a_viewer_gets_the_picture_or_is_missed_before_the_work() {
    let place = Place::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let viewer = std::thread::spawn(move || {
        let mut received = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut received).unwrap();
        received
    });
    place.render("seen.exr", &["--spp", "4", "--tev", &address]);
    let received = viewer.join().unwrap();
    // Packets begin with their length; the kinds are CreateImage (4) and UpdateImageV3 (6).
    let (mut kinds, mut rest) = (Vec::new(), &*received);
    let mut last = rest;
    while let Some((length, _)) = rest.split_first_chunk::<4>() {
        let length = u32::from_le_bytes(*length) as usize;
        kinds.push(rest[4]);
        (last, rest) = rest.split_at(length);
    }
    assert_eq!((kinds[0], *kinds.last().unwrap()), (4, 6));
    // The last one ends in the finished picture: red, green, blue of each pixel.
    let (values, _) = last[last.len() - 12 * 21 * 14..].as_chunks::<4>();
    let shown: Vec<u32> = values.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
    let stored = pixels(&place.path("seen.exr"));
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        let expected = &stored.iter().find(|(one, _)| one == name).unwrap().1;
        assert!(shown.iter().skip(channel).step_by(3).eq(expected), "{name}");
    }
    let message = place.refused("unseen.exr", &["--tev", &address]);
    assert!(message.contains("no viewer answers there") && !Path::new(&place.path("unseen.exr")).exists(), "{message}");
}

#[test]
fn channels_on_request_are_in_the_file() {
    let place = Place::new();
    place.render("all.exr", &["--spp", "2", "--channels", "spectrum,variance,normal,albedo,thickness,angle"]);
    let names: Vec<String> = pixels(&place.path("all.exr")).into_iter().map(|(name, _)| name).collect();
    for name in ["R", "S0.400,000000nm", "S0.700,000000nm", "variance.G", "normal.Z", "albedo.B", "thickness", "angle"]
    {
        assert!(names.iter().any(|one| one == name), "{name}: {names:?}");
    }
    assert_eq!(names.len(), 45);
    // Parts with further channels make a PNG of their colours.
    place.render("part.exr", &["--spp", "1", "--channels", "normal", "--keep-sums"]);
    assert_eq!(place.merge(&["part.exr"], "part.png", &[])[..4], *b"\x89PNG");
    let output = snowblue(&words(&place.rendering("bad.png", &["--channels", "normal"])));
    assert_eq!(output.status.code(), Some(2));
}

//! Pictures in parts and resumed: identical to a single run to the last bit; parts of others are refused.
//! `scripts/test-faults` interrupts and kills them.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod shell;

use std::io::Read as _;
use std::net::TcpListener;
use std::path::Path;

use shell::{assert_refused, decoded, shipped_scene, stdout};

/// Kinds of packets of the viewer's protocol: CreateImage and UpdateImageV3.
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;

/// A folder with the scene of the block, with coarse cells of the light field to save time.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self::with(|scene| scene + "\n[light_field]\nstep_mm = 60\n")
    }

    /// By PCASnow, which solves for no light field.
    fn without_field() -> Self {
        Self::with(|scene| scene.replace("[integrator]\n", "[integrator]\ntype = \"pcasnow\"\n"))
    }

    fn with(change: impl Fn(String) -> String) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let scene = std::fs::read_to_string(shipped_scene("block_30cm.toml")).unwrap();
        std::fs::write(folder.path().join("scene.toml"), change(scene)).unwrap();
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

    fn assert_render_refused(&self, output: &str, more: &[&str], expected: &[&str]) {
        assert_refused(&words(&self.rendering(output, more)), expected);
    }

    fn assert_merge_refused(&self, parts: &[&str], output: &str, expected: &[&str]) {
        assert_refused(&words(&self.merging(parts, output, &[])), expected);
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
fn parts_merge_to_the_whole_picture() {
    let folder = Folder::new();
    folder.render("whole.exr", &["--spp", "10"]);
    let whole = pixels(&folder.path("whole.exr"));
    assert_eq!(whole.len(), 4, "a finished picture has colours, and says where they show snow");
    folder.render("a.exr", &["--spp-range", "0:3"]);
    folder.render("b.exr", &["--spp-range", "3:10", "--crop", "0:8,0:14", "--threads", "1"]);
    folder.render("c.exr", &["--spp-range", "3:10", "--crop", "8:21,0:5", "--threads", "3"]);
    folder.render("d.exr", &["--spp-range", "3:10", "--crop", "8:21,5:14"]);
    let parts = ["d.exr", "a.exr", "c.exr", "b.exr"];
    folder.merge(&parts, "merged.exr", &[]);
    assert_eq!(pixels(&folder.path("merged.exr")), whole);
    assert!(folder.bytes("merged.exr") == folder.bytes("whole.exr"), "also what the file says of the scene");
    // The content of a scene matters, and not the name of its file, on which a merged file says nothing then.
    std::fs::rename(folder.path("scene.toml"), folder.path("moved.toml")).unwrap();
    let mut moved = folder.rendering("moved.exr", &["--spp-range", "3:10", "--crop", "8:21,5:14"]);
    moved[1] = folder.path("moved.toml");
    stdout(&words(&moved));
    std::fs::rename(folder.path("moved.toml"), folder.path("scene.toml")).unwrap();
    let merged = folder.merge(&["moved.exr", "a.exr", "c.exr", "b.exr"], "merged.exr", &[]);
    assert!(!merged.windows(7).any(|bytes| bytes == b"Scene: "));
    // A merged part can be merged again.
    folder.merge(&["b.exr", "d.exr", "c.exr"], "most.exr", &["--keep-sums"]);
    folder.merge(&["most.exr", "a.exr"], "merged.exr", &[]);
    assert_eq!(pixels(&folder.path("merged.exr")), whole);
    // A cropped pixel equals that of the whole picture.
    folder.render("pixel.exr", &["--spp", "10", "--crop", "17:18,5:6"]);
    for ((name, all), (part, one)) in whole.iter().zip(pixels(&folder.path("pixel.exr"))) {
        assert_eq!((name, all[5 * 21 + 17]), (&part, one[0]));
    }
    // As PNG, with the exposure of the scene or another.
    let bright = decoded(&folder.render("whole.png", &["--spp", "10"]));
    assert!(bright == decoded(&folder.merge(&parts, "merged.png", &[])));
    assert!(folder.bytes("merged.png") == folder.bytes("whole.png"));
    for other in [["--exposure", "1"], ["--tone", "agx"], ["--bloom", "0.5"]] {
        assert!(bright != decoded(&folder.merge(&parts, "merged.png", &other)), "{other:?}");
    }
    folder.merge(&parts, "merged.exr", &["--keep-sums"]);
    assert!(bright == decoded(&folder.merge(&["merged.exr"], "merged.png", &[])), "through another file");
    folder.render("dark.exr", &["--spp-range", "3:5", "--exposure", "-5"]);
    folder.merge(&["a.exr", "dark.exr"], "merged.exr", &[]);
    let expected = ["exposure", "-1.2", "a.exr", "-5", "dark.exr", "--exposure"];
    folder.assert_merge_refused(&["a.exr", "dark.exr"], "merged.png", &expected);
}

#[test]
fn parts_of_different_pictures_are_refused_in_one_line() {
    let folder = Folder::without_field();
    folder.render("a.exr", &["--spp-range", "0:4"]);
    folder.render("b.exr", &["--spp-range", "3:6"]);
    folder.render("late.exr", &["--spp-range", "5:6"]);
    folder.render("seed.exr", &["--spp-range", "4:6", "--seed", "7"]);
    folder.render("view.exr", &["--spp-range", "4:6", "--path", "view"]);
    folder.render("size.exr", &["--spp-range", "4:6", "--width", "22"]);
    folder.render("normal.exr", &["--spp-range", "4:6", "--aovs", "rgb,normal"]);
    folder.render("tile.exr", &["--spp", "4", "--crop", "0:2,0:2"]);
    folder.render("corner.exr", &["--spp", "4", "--crop", "3:5,3:5"]);
    folder.render("plain.exr", &["--spp", "1"]);
    let scene = std::fs::read_to_string(folder.path("scene.toml")).unwrap();
    let another_light = "[[light]]\ntype = \"point\"\nposition = [0, -2, 2]\nradiant_intensity_w_sr = 1\n";
    std::fs::write(folder.path("scene.toml"), format!("{scene}\n{another_light}")).unwrap();
    folder.render("scene.exr", &["--spp-range", "4:6"]);
    snowblue_data::embedded().write(Path::new(&folder.path("table.nc"))).unwrap();
    std::fs::write(folder.path("empty.exr"), "").unwrap();
    let refusals = [
        (["b.exr", "a.exr"], &["b.exr: the samples 3:6 of pixel 0,0 do not follow 0:4 of the other parts"][..]),
        (["a.exr", "late.exr"], &["late.exr: the samples 5:6 of pixel 0,0 do not follow 0:4"]),
        (["a.exr", "seed.exr"], &["seed", "1", "7"]),
        (["a.exr", "view.exr"], &["path", "view"]),
        (["a.exr", "size.exr"], &["width", "21", "22"]),
        (["a.exr", "normal.exr"], &["AOVs", "rgb", "rgb,normal"]),
        (["a.exr", "scene.exr"], &["a.exr", "scene.exr", "scene"]),
        (["tile.exr", "corner.exr"], &["pixel 2,0"]),
        (["a.exr", "plain.exr"], &["plain.exr", "--keep-sums"]),
        (["a.exr", "table.nc"], &["a.exr is a picture", "table.nc is a table", "kind"]),
        (["a.exr", "scene.toml"], &["scene.toml: is neither a picture", ".exr", ".nc"]),
        (["empty.exr", "a.exr"], &["empty.exr: is empty"]),
        (["a.exr", "missing.exr"], &["missing.exr"]),
    ];
    let before = folder.names();
    for (parts, expected) in refusals {
        folder.assert_merge_refused(&parts, "no.exr", expected);
    }
    for (more, expected) in [
        (
            vec!["--crop", "0:22,0:14"],
            &["--crop has the columns 0:22, but the picture has 21 × 14 pixels: columns lie in 0:21"][..],
        ),
        (vec!["--crop", "0:21,3:15"], &["--crop has the rows 3:15, but", "rows lie in 0:14"]),
        (vec!["--crop", "5:5,0:1"], &["--crop", "the columns are '5:5', but must be X0:X1"]),
        (vec!["--crop", "5:6"], &["--crop", "the rows are missing", "X0:X1,Y0:Y1", "500:516,300:316"]),
        (vec!["--spp-range", "0:4294967296"], &["--spp-range", "4294967296", "4294967295"]),
        (vec!["--spp-range", "0:4", "--spp", "4"], &["--spp-range", "--spp"]),
        (vec!["--aovs", "depth"], &["'depth'", "rgb", "spectrum"]),
        (vec!["--checkpoint", "0"], &["--checkpoint", "0 minutes", "0.01–100000 minutes"]),
    ] {
        folder.assert_render_refused("no.exr", &more, expected);
    }
    for option in [vec!["--resume"], vec!["--keep-sums"], vec!["--aovs", "albedo"]] {
        folder.assert_render_refused("no.png", &option, &[option[0], ".exr", "PNG"]);
    }
    assert_eq!(folder.names(), before, "nothing was written");
}

#[test]
fn a_picture_is_resumed_to_more_samples() {
    let folder = Folder::without_field();
    folder.render("whole.exr", &["--spp", "11", "--keep-sums"]);
    let whole = pixels(&folder.path("whole.exr"));
    for samples in ["4", "11", "11"] {
        folder.render("grown.exr", &["--spp", samples, "--resume"]);
    }
    assert!(pixels(&folder.path("grown.exr")) == whole);
    let before = folder.bytes("grown.exr");
    let other_seed = ["--spp", "20", "--resume", "--seed", "3"];
    folder.assert_render_refused("grown.exr", &other_seed, &["grown.exr", "resumed", "seed", "1", "3"]);
    let later = ["--spp-range", "11:20", "--resume"];
    folder.assert_render_refused(
        "grown.exr",
        &later,
        &["grown.exr", "resumed", "begins with sample 0, not 11", "merge"],
    );
    assert!(folder.bytes("grown.exr") == before, "nothing was written");
    // First a crop, then the rest.
    folder.render("detail.exr", &["--spp", "11", "--crop", "3:9,4:8", "--resume"]);
    folder.render("detail.exr", &["--spp", "11", "--resume"]);
    assert!(pixels(&folder.path("detail.exr")) == whole);
}

#[test]
fn a_viewer_gets_the_picture_and_a_missing_one_is_reported_first() {
    let folder = Folder::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let viewer = std::thread::spawn(move || {
        let mut received = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut received).unwrap();
        received
    });
    folder.render("seen.exr", &["--spp", "4", "--tev", &address]);
    let received = viewer.join().unwrap();
    // Packets start with their length.
    let (mut kinds, mut rest) = (Vec::new(), &*received);
    let mut last = rest;
    while let Some((length, _)) = rest.split_first_chunk::<4>() {
        let length = u32::from_le_bytes(*length) as usize;
        kinds.push(rest[4]);
        (last, rest) = rest.split_at(length);
    }
    // A coarse picture comes before the light field, and the picture is the same as without a viewer.
    assert!(kinds.len() >= 3 && kinds[0] == CREATE_IMAGE && kinds[1..].iter().all(|kind| *kind == UPDATE_IMAGE));
    assert!(folder.bytes("seen.exr") == folder.render("alone.exr", &["--spp", "4"]));
    // The last packet ends with the finished picture: red, green, blue of each pixel.
    let (values, _) = last[last.len() - 12 * 21 * 14..].as_chunks::<4>();
    let shown: Vec<u32> = values.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
    let stored = pixels(&folder.path("seen.exr"));
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        let expected = &stored.iter().find(|(one, _)| one == name).unwrap().1;
        assert!(shown.iter().skip(channel).step_by(3).eq(expected), "{name}");
    }
    folder.assert_render_refused("unseen.exr", &["--tev", &address], &["--tev", &address]);
    assert!(!Path::new(&folder.path("unseen.exr")).exists());
}

#[test]
fn requested_aovs_are_in_the_file() {
    let folder = Folder::without_field();
    folder.render("all.exr", &["--spp", "2", "--aovs", "spectrum,variance,normal,albedo,thickness,angle"]);
    let names: Vec<String> = pixels(&folder.path("all.exr")).into_iter().map(|(name, _)| name).collect();
    for name in ["R", "S0.400,000000nm", "S0.700,000000nm", "variance.G", "normal.Z", "albedo.B", "thickness", "angle"]
    {
        assert!(names.iter().any(|one| one == name), "{name}: {names:?}");
    }
    assert_eq!(names.len(), 46);
    // A PNG is made of the colours of parts with other AOVs.
    folder.render("part.exr", &["--spp", "1", "--aovs", "normal", "--keep-sums"]);
    assert_eq!(folder.merge(&["part.exr"], "part.png", &[])[..4], *b"\x89PNG");
    folder.assert_render_refused("bad.png", &["--aovs", "normal"], &["--aovs", ".exr"]);
}

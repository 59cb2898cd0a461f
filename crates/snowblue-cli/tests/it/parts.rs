//! Pictures in parts and resumed: identical to a single run to the last bit; parts of others are refused.
//! `scripts/test-faults` interrupts and kills them.

use std::io::Read as _;
use std::net::TcpListener;
use std::path::Path;

use crate::shell::{BLOCK, Folder, decoded};

/// Kinds of packets of the viewer's protocol: CreateImage and UpdateImageV3.
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;

/// The scene of the block in 21 × 14 pixels.
const SMALL: &str = "render scene.toml --width 21 --height 14";

/// A folder with the scene of the block, with coarse cells of the light field to save time.
fn with_field() -> Folder {
    let folder = Folder::new();
    folder.write("scene.toml", format!("{BLOCK}\n[light_field]\nstep_mm = 60\n"));
    folder
}

/// A folder with the scene of the block by PCASnow, which solves for no light field.
fn without_field() -> Folder {
    let folder = Folder::new();
    folder.write("scene.toml", BLOCK.replace("[integrator]\n", "[integrator]\ntype = \"pcasnow\"\n"));
    folder
}

/// Renders a small picture of the scene with more options.
fn render(folder: &Folder, output: &str, more: &str) -> Vec<u8> {
    folder.stdout(&format!("{SMALL} -o {output} {more}"));
    folder.bytes(output)
}

/// Merges parts.
fn merge(folder: &Folder, parts: &str, output: &str) -> Vec<u8> {
    folder.stdout(&format!("merge {parts} -o {output}"));
    folder.bytes(output)
}

/// The pixels of all channels of a picture, as bits.
fn pixels(path: &Path) -> Vec<(String, Vec<u32>)> {
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
    let folder = without_field();
    let pixels = |name: &str| pixels(&folder.path(name));
    render(&folder, "whole.exr", "--spp 5");
    let whole = pixels("whole.exr");
    assert_eq!(whole.len(), 4, "a finished picture has colours, and says where they show snow");
    render(&folder, "a.exr", "--spp-range 0:2");
    render(&folder, "b.exr", "--spp-range 2:5 --crop 0:8,0:14 --threads 1");
    render(&folder, "c.exr", "--spp-range 2:5 --crop 8:21,0:5 --threads 3");
    render(&folder, "d.exr", "--spp-range 2:5 --crop 8:21,5:14");
    let parts = "d.exr a.exr c.exr b.exr";
    merge(&folder, parts, "merged.exr");
    assert_eq!(pixels("merged.exr"), whole);
    assert!(folder.bytes("merged.exr") == folder.bytes("whole.exr"), "also what the file says of the scene");
    // The content of a scene matters, and not the name of its file, on which a merged file says nothing then.
    folder.write("moved.toml", folder.bytes("scene.toml"));
    let small = SMALL.replace("scene.toml", "moved.toml");
    folder.stdout(&format!("{small} -o moved.exr --spp-range 2:5 --crop 8:21,5:14"));
    let merged = merge(&folder, "moved.exr a.exr c.exr b.exr", "merged.exr");
    assert!(!merged.windows(7).any(|bytes| bytes == b"Scene: "));
    // A merged part can be merged again.
    merge(&folder, "b.exr d.exr c.exr --keep-sums", "most.exr");
    merge(&folder, "most.exr a.exr", "merged.exr");
    assert_eq!(pixels("merged.exr"), whole);
    // A cropped pixel equals that of the whole picture.
    render(&folder, "pixel.exr", "--spp 5 --crop 17:18,5:6");
    for ((name, all), (part, one)) in whole.iter().zip(pixels("pixel.exr")) {
        assert_eq!((name, all[5 * 21 + 17]), (&part, one[0]));
    }
    // As PNG, with the exposure of the scene or another.
    let bright = decoded(&render(&folder, "whole.png", "--spp 5"));
    assert!(bright == decoded(&merge(&folder, parts, "merged.png")));
    assert!(folder.bytes("merged.png") == folder.bytes("whole.png"));
    for other in ["--exposure 1", "--tone agx"] {
        assert!(bright != decoded(&merge(&folder, &format!("{parts} {other}"), "merged.png")), "{other}");
    }
    merge(&folder, &format!("{parts} --keep-sums"), "merged.exr");
    assert!(bright == decoded(&merge(&folder, "merged.exr", "merged.png")), "through another file");
    render(&folder, "dark.exr", "--spp-range 2:3 --exposure -5");
    merge(&folder, "a.exr dark.exr --exposure 0", "merged.exr");
    let expected = ["exposure", "-1.2", "a.exr", "-5", "dark.exr", "--exposure"];
    folder.assert_refused("merge a.exr dark.exr -o new.png", &expected);
}

#[test]
fn parts_with_alpha_and_depth_merge_to_the_whole_picture() {
    let folder = without_field();
    let aovs = "--aovs alpha,depth,position";
    render(&folder, "whole.exr", &format!("{aovs} --spp 5"));
    render(&folder, "a.exr", &format!("{aovs} --spp-range 0:2"));
    render(&folder, "b.exr", &format!("{aovs} --spp-range 2:5"));
    merge(&folder, "b.exr a.exr", "merged.exr");
    assert!(folder.bytes("merged.exr") == folder.bytes("whole.exr"));
}

#[test]
fn parts_of_different_pictures_are_refused() {
    let folder = without_field();
    render(&folder, "a.exr", "--spp-range 0:4");
    render(&folder, "b.exr", "--spp-range 3:6");
    render(&folder, "late.exr", "--spp-range 5:6");
    render(&folder, "seed.exr", "--spp-range 4:6 --seed 7");
    render(&folder, "view.exr", "--spp-range 4:6 --path view");
    folder.stdout("render scene.toml --width 22 --height 14 -o size.exr --spp-range 4:6");
    render(&folder, "normal.exr", "--spp-range 4:6 --aovs rgb,normal");
    render(&folder, "alpha.exr", "--spp-range 4:6 --aovs alpha");
    render(&folder, "tile.exr", "--spp 4 --crop 0:2,0:2");
    render(&folder, "corner.exr", "--spp 4 --crop 3:5,3:5");
    render(&folder, "plain.exr", "--spp 1");
    let another_light = "[[light]]\ntype = \"point\"\nposition = [0, -2, 2]\nradiant_intensity_w_sr = 1\n";
    folder.write("scene.toml", format!("{}\n{another_light}", folder.text("scene.toml")));
    render(&folder, "scene.exr", "--spp-range 4:6");
    snowblue_data::embedded().write(&folder.path("table.nc")).unwrap();
    folder.write("empty.exr", "");
    for (parts, words) in [
        ("b.exr a.exr", &["b.exr: the samples 3:6 of pixel 0,0 do not follow 0:4 of the other parts"][..]),
        ("a.exr late.exr", &["late.exr: the samples 5:6 of pixel 0,0 do not follow 0:4"]),
        ("a.exr seed.exr", &["seed", "1", "7"]),
        ("a.exr view.exr", &["path", "view"]),
        ("a.exr size.exr", &["width", "21", "22"]),
        ("a.exr normal.exr", &["AOVs", "rgb", "rgb,normal"]),
        ("a.exr alpha.exr", &["AOVs", "rgb", "rgb,snow,alpha"]),
        ("a.exr scene.exr", &["a.exr", "scene.exr", "scene"]),
        ("tile.exr corner.exr", &["pixel 2,0"]),
        ("a.exr plain.exr", &["plain.exr", "--keep-sums"]),
        ("a.exr table.nc", &["a.exr is a picture", "table.nc is a table", "kind"]),
        ("a.exr scene.toml", &["scene.toml: is neither a picture", ".exr", ".nc"]),
        ("a.exr --white D50", &["--white has no effect: ", ".png"]),
        ("empty.exr a.exr", &["empty.exr: is empty"]),
        ("a.exr missing.exr", &["missing.exr"]),
    ] {
        folder.assert_refused(&format!("merge {parts} -o no.exr"), words);
    }
    folder.assert_refused("merge a.exr -o a.exr", &["a.exr", "overwritten"]);
}

#[test]
fn a_picture_is_resumed_to_more_samples() {
    let folder = without_field();
    let pixels = |name: &str| pixels(&folder.path(name));
    render(&folder, "whole.exr", "--spp 11 --keep-sums");
    let whole = pixels("whole.exr");
    for samples in [4, 11, 11] {
        render(&folder, "grown.exr", &format!("--resume --spp {samples}"));
    }
    assert!(pixels("grown.exr") == whole);
    let resumed = format!("{SMALL} -o grown.exr --resume");
    folder.assert_refused(&format!("{resumed} --spp 20 --seed 3"), &["grown.exr", "resumed", "seed", "1", "3"]);
    let later = ["grown.exr", "resumed", "begins with sample 0, not 11", "merge"];
    folder.assert_refused(&format!("{resumed} --spp-range 11:20"), &later);
    // First a crop, then the rest.
    render(&folder, "detail.exr", "--resume --spp 11 --crop 3:9,4:8");
    render(&folder, "detail.exr", "--resume --spp 11");
    assert!(pixels("detail.exr") == whole);
}

#[test]
fn a_viewer_gets_the_picture_and_a_missing_one_is_reported_first() {
    let folder = with_field();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let viewer = std::thread::spawn(move || {
        let mut received = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut received).unwrap();
        received
    });
    let seen = render(&folder, "seen.exr", &format!("--spp 2 --tev {address}"));
    let received = viewer.join().unwrap();
    // Packets start with their length.
    let (mut kinds, mut rest) = (Vec::new(), &*received);
    let mut last = rest;
    while let Some((length, _)) = rest.split_first_chunk::<4>() {
        let length = u32::from_le_bytes(*length) as usize;
        kinds.push(rest[4]);
        (last, rest) = rest.split_at(length);
    }
    // A coarse picture comes before the light field, and the picture is that of its parts without a viewer.
    assert!(kinds.len() >= 3 && kinds[0] == CREATE_IMAGE && kinds[1..].iter().all(|kind| *kind == UPDATE_IMAGE));
    render(&folder, "a.exr", "--spp-range 0:1 --threads 1");
    render(&folder, "b.exr", "--spp-range 1:2");
    assert!(seen == merge(&folder, "a.exr b.exr", "alone.exr"));
    // The last packet ends with the finished picture: red, green, blue of each pixel.
    let (values, _) = last[last.len() - 12 * 21 * 14..].as_chunks::<4>();
    let shown: Vec<u32> = values.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
    let stored = pixels(&folder.path("seen.exr"));
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        let expected = &stored.iter().find(|(one, _)| one == name).unwrap().1;
        assert!(shown.iter().skip(channel).step_by(3).eq(expected), "{name}");
    }
    let address = address.to_string();
    folder.assert_refused(&format!("{SMALL} -o unseen.exr --tev {address}"), &["--tev", &address]);
}

#[test]
fn requested_aovs_are_in_the_file() {
    let folder = without_field();
    render(&folder, "all.exr", "--spp 2 --aovs spectrum,variance,normal,albedo,thickness,angle,position,depth,alpha");
    let names: Vec<String> = pixels(&folder.path("all.exr")).into_iter().map(|(name, _)| name).collect();
    for name in ["R", "S0.400,000000nm", "S0.700,000000nm", "variance.G", "normal.Z", "albedo.B", "thickness", "angle"]
        .into_iter()
        .chain(["A", "depth.Z", "position.X", "position.Y", "position.Z"])
    {
        assert!(names.iter().any(|one| one == name), "{name}: {names:?}");
    }
    assert_eq!(names.len(), 51);
    // A PNG is made of the colours of parts with other AOVs.
    render(&folder, "part.exr", "--spp 1 --aovs normal --keep-sums");
    assert_eq!(merge(&folder, "part.exr", "part.png")[..4], *b"\x89PNG");
}

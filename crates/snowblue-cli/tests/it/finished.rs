//! Another exposure, tone curve and white for a picture that is there: the PNG of `merge` is the PNG of `render`.

use exr::meta::attribute::Chromaticities;
use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, Vec2, WritableImage as _};

use crate::shell::{BLOCK, Folder, decoded};

/// Writes an EXR with channels of 2 × 1 pixels, as another program does.
fn write_exr(folder: &Folder, name: &str, channels: &[(&str, [f32; 2])], chromaticities: Option<Chromaticities>) {
    let channels = channels.iter().map(|(name, values)| AnyChannel::new(*name, FlatSamples::F32(values.to_vec())));
    let mut image = Image::from_channels((2, 1), AnyChannels::sort(channels.collect()));
    image.attributes.chromaticities = chromaticities;
    image.write().to_file(folder.path(name)).unwrap();
}

/// The pixels of a PNG.
fn shown(folder: &Folder, name: &str) -> Vec<u8> {
    decoded(&folder.bytes(name)).1
}

/// The greatest difference of code values.
fn difference(one: &[u8], other: &[u8]) -> u8 {
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).map(|(one, other)| one.abs_diff(*other)).max().unwrap()
}

#[test]
fn a_picture_is_shown_as_if_it_were_rendered_for_it() {
    let folder = Folder::new();
    let sky = "[sky]\nsun = { elevation_deg = 20, azimuth_deg = 200 }\n";
    folder.write(
        "scene.toml",
        format!("{}\n{sky}", BLOCK.replace("[integrator]\n", "[integrator]\ntype = \"pcasnow\"\n")),
    );
    let render = "render scene.toml --width 21 --height 14 --spp 2";
    folder.stdout(&format!("{render} --white 4500K -o finished.exr"));
    folder.stdout(&format!("{render} --white 4500K --keep-sums -o sums.exr"));
    let mut before: Vec<Vec<u8>> = Vec::new();
    for options in [
        "--exposure -1.2 --tone filmic --white 4500K",
        "--exposure -5 --tone agx --white D65",
        "--exposure auto --tone none --white sky",
        "--exposure auto --tone none --white A",
    ] {
        folder.stdout(&format!("{render} {options} -o expected.png"));
        let expected = shown(&folder, "expected.png");
        for source in ["finished.exr", "sums.exr"] {
            folder.stdout(&format!("merge {source} {options} -o shown.png"));
            // An EXR has single precision.
            assert!(difference(&shown(&folder, "shown.png"), &expected) <= 1, "{source} {options}");
        }
        assert!(before.iter().all(|other| difference(other, &expected) > 8), "{options}");
        before.push(expected);
    }
    // Without options it is the picture of the scene.
    folder.stdout(&format!("{render} --white 4500K -o expected.png"));
    folder.stdout("merge finished.exr -o shown.png");
    assert!(difference(&shown(&folder, "shown.png"), &shown(&folder, "expected.png")) <= 1);
    folder.assert_refused("merge finished.exr -o other.exr", &["finished.exr", "no sums", "--keep-sums"]);
}

#[test]
fn pictures_of_other_programs_are_shown() {
    let folder = Folder::new();
    let grey = |name: &str| {
        let names = ["R", "G", "B"].map(|channel| format!("{name}{channel}"));
        names.map(|name| (name, [0.5_f32, 0.25]))
    };
    let write = |file: &str, name: &str, chromaticities| {
        let channels = grey(name);
        let channels: Vec<(&str, [f32; 2])> = channels.iter().map(|(name, values)| (&**name, *values)).collect();
        write_exr(&folder, file, &channels, chromaticities);
    };
    // sRGB of 0.5, 0.25, and of 1.0 for one stop more. Greys stay grey with any primaries and white.
    let at = |x: f32, y: f32| Vec2(x, y);
    let ap0 = Chromaticities {
        red: at(0.7347, 0.2653),
        green: at(0.0, 1.0),
        blue: at(1e-4, -0.077),
        white: at(0.32168, 0.33767),
    };
    write("plain.exr", "", None);
    write("layers.exr", "ViewLayer.Combined.", Some(ap0));
    for file in ["plain.exr", "layers.exr"] {
        folder.stdout(&format!("merge {file} --exposure 0 --tone none -o shown.png"));
        assert_eq!(shown(&folder, "shown.png"), [188, 188, 188, 137, 137, 137], "{file}");
        folder.stdout(&format!("merge {file} --exposure 1 --tone none -o shown.png"));
        assert_eq!(shown(&folder, "shown.png"), [255, 255, 255, 188, 188, 188], "{file}");
        // For a warm light that looks white, grey turns blue.
        folder.stdout(&format!("merge {file} --exposure 0 --tone none --white 3000K -o shown.png"));
        let colour = shown(&folder, "shown.png");
        assert!(colour[3] < 137 && colour[5] > 137, "{file}: {colour:?}");
        let lacks = [file, "--white", "sky", "snowblueSky"];
        folder.assert_refused(&format!("merge {file} --exposure 0 --white sky -o no.png"), &lacks);
    }
    assert!(folder.stderr("merge layers.exr -o shown.png").contains("the layer ViewLayer.Combined"));
    assert!(folder.stderr("merge plain.exr --exposure auto -o shown.png").contains("no channel `snow`"));
    let twice = Chromaticities { green: ap0.red, ..ap0 };
    write("wrong.exr", "", Some(twice));
    write_exr(&folder, "depth.exr", &[("ViewLayer.Depth.Z", [1.0, 2.0])], None);
    write_exr(&folder, "nan.exr", &[("R", [0.0; 2]), ("G", [0.0, f32::NAN]), ("B", [0.0; 2])], None);
    for (file, words) in [
        ("wrong.exr", &["wrong.exr", "chromaticities", "0.7347 0.2653"][..]),
        ("depth.exr", &["depth.exr", "R, G and B", "ViewLayer.Depth.Z"]),
        ("nan.exr", &["nan.exr", "pixel 1,0 is 0, NaN, 0", "finite"]),
    ] {
        folder.assert_refused(&format!("merge {file} -o no.png"), words);
    }
}

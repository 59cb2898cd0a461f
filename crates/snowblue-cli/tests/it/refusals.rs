//! What the command refuses, and what its message names: in one line, with exit code 2, and before anything is written.

use crate::batch::PITS;
use crate::layers::PACK;
use crate::shell::{BLOCK, Folder};
use crate::tables::AXES;

/// What a message names: quantity, value, range, unit, option, file or line.
type Words = &'static [&'static str];

/// Files that are right or have no right form, for the command lines below.
const FILES: &[(&str, &[u8])] = &[
    ("pits.csv", PITS.as_bytes()),
    ("full.csv", b"density_kg_m3,black_carbon_ng_g\n200,10\n300,20\n"),
    ("radii.csv", b"optical_radius_um\n50\n"),
    ("sizes.csv", b"grain_size_um\n300\n"),
    ("areas.csv", b"ssa_m2_kg\n20\n"),
    ("pack.toml", PACK.as_bytes()),
    ("spectrum.csv", b"400,0.5\n420,0.5\n"),
    ("latin1.toml", b"[camera]\n# \xe9\n"),
    ("bare.toml", b"[camera]\nposition = [0, -9, 9]\nlook_at = [0, 0, 0]\n[environment]\nradiance_w_m2_sr = 1\n"),
    ("sheet.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    ("cut.ply", b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"),
    ("cut.glb", b"glTF\x02\0\0\0\xff\0\0\0"),
];

/// Commands, what follows them, and what the message names.
const LINES: &[(&str, &[(&str, Words)])] = &[
    ("spectrum", SPECTRUM),
    (
        "spectrum --layers",
        &[
            ("none.toml", &["none.toml"]),
            ("latin1.toml", &["latin1.toml:2: the line is not text (UTF-8, or UTF-16 with a byte order mark)"]),
            ("pack.toml --format csv -o pack.toml", &["pack.toml: would be overwritten"]),
            ("x.toml --ice picard2016", &["--layers", "--ice"]),
            ("x.toml --grain-size 100", &["--layers", "--grain-size"]),
            ("x.toml --ssa 20", &["--layers", "--ssa"]),
            ("x.toml --facetness 1", &["--layers", "--facetness"]),
            ("x.toml --density 100", &["--layers", "--density"]),
            ("x.toml --thickness 1", &["--layers", "--thickness"]),
            ("x.toml --temperature -1", &["--layers", "--temperature"]),
        ],
    ),
    (
        "spectrum --batch",
        &[
            ("missing.csv", &["missing.csv"]),
            ("pits.csv -o pits.csv", &["pits.csv: would be overwritten"]),
            ("pits.csv --wavelengths 5000", &["snowblue: wavelength is 5000 nm"]),
            ("pits.csv --temperature=-70", &[": temperature is -70"]),
            ("pits.csv --angle 0,60", &["--angle has several values", "column"]),
            ("pits.csv --ssa 10,20", &["--ssa has several values", "--batch"]),
            ("full.csv --density 150", &["--density", "has no effect", "each line", "full"]),
            ("full.csv --impurity black-carbon=3", &["--impurity", "has no effect", "each line", "full"]),
            ("radii.csv --grain-size 300:800", &[":1:", "optical_radius_um", "--grain-size"]),
            ("radii.csv --size-measure volume-diameter", &[":1:", "--size-measure"]),
            ("sizes.csv --optical-radius 50", &[":1:", "grain_size_um", "--optical-radius"]),
            ("areas.csv --grain-size 300", &[":1:", "ssa_m2_kg", "--grain-size"]),
        ],
    ),
    (
        // Work that would take longer than a test may: outputs are checked first.
        "spectrum --grain-size 400 --engine montecarlo --rays 1000000000",
        &[
            ("-o spectrum.xyz", &["spectrum.xyz", ".csv", "--format"]),
            ("-o missing/a.csv", &["missing/a.csv: its folder does not exist"]),
            ("-o ./ --format csv", &["is a folder"]),
            ("-o pits.csv/a.csv", &["pits.csv/a.csv: its folder is a file"]),
        ],
    ),
    (
        "spectrum --sky",
        &[
            ("25", &["--depths"]),
            ("25 --depths 1 --angle 3", &["--angle", "--sky"]),
            ("25 --depths 1 --engine montecarlo", &["--sky", "--engine ordinates"]),
            ("25 --depths 1 --thickness 2,5", &["--sky", "--thickness"]),
            ("25,3 --depths 1", &["--sky", "LATITUDE,LONGITUDE,TIME"]),
            ("95 --depths 1", &["sun elevation", "95°", "-90–90°"]),
            ("47,11,2026-02-30 --depths 1", &["day is 30", "28 days"]),
            ("25 --depths 1 --turbidity 20", &["turbidity", "20", "1–10"]),
            ("25 --depths 1 --cloud-thickness 20", &["--overcast"]),
            ("25 --depths 1 --overcast --cloud-thickness 0", &["optical thickness of clouds", "0", "1–200"]),
        ],
    ),
    (
        "bsdf",
        &[
            ("--angle 90", &["angle", "90°", "0–89.99°"]),
            ("--patches 4", &["--patches", "4", "RINGSxSECTORS"]),
            ("--rays 1", &["invalid value '1' for '--rays <", ">': must be a whole number of 2–1000000000000\n"]),
        ],
    ),
    ("slab", &[("--one-minus-omega 2 --g 0 --tau 1", &["--one-minus-omega", "2", "0–1"])]),
    (
        "sky",
        &[
            ("--elevation -93.2", &["sun elevation", "-93.2°", "-90–90°"]),
            ("--elevation 3 --precipitable-water 11", &["precipitable water", "11 cm", "0–10 cm"]),
            ("--elevation 3 --overcast --cloud-thickness 201", &["optical thickness of clouds", "201", "1–200"]),
            ("--elevation 30 --turbidity 11", &["turbidity", "11", "1–10"]),
            ("--elevation 30 --ground-albedo 2", &["ground albedo", "2", "0–1"]),
            ("--elevation 30 --wavelengths 450,2501", &["wavelength", "2501", "320–2500 nm"]),
            ("", &["--elevation", "--latitude", "--longitude", "--time"]),
            ("--elevation 3 --refraction", &["--elevation", "--refraction"]),
            ("--latitude 47", &["--longitude", "--time"]),
            ("--elevation 3 --overcast --turbidity 4", &["--overcast", "--turbidity"]),
            ("--latitude 91 --longitude 11.39 --time 2026-02-01T12:00Z", &["latitude", "91°", "-90–90°"]),
            ("--latitude 47 --longitude 11.39 --time 2026-02-01T12:00", &["2026-02-01T12:00", "offset from UTC"]),
            ("--latitude 47 --longitude 11.39 --time 2026-02-30T12:00Z", &["day", "30", "28 days"]),
        ],
    ),
    (
        "color",
        &[
            ("--illuminant D66", &["D66", "D65"]),
            ("-o a.xlsx", &["a.xlsx: the file must end in .csv, .json or .txt, or give --format"]),
            ("--ssa 10,40", &["--ssa has several values", "spectrum"]),
            ("--exposure bright", &["--exposure", "'bright'", "stops", "'auto'"]),
            ("--exposure 101", &["exposure", "101", "-100 to 100 stops"]),
            ("--thickness 5,inf", &["thickness is inf cm", "--reflected"]),
            ("--spectrum spectrum.csv -o spectrum.csv", &["spectrum.csv: would be overwritten"]),
            ("--ssa 30 --density 200 --snow fresh", &["--snow has no effect: ", "--ssa and --density"]),
        ],
    ),
    (
        "match",
        &[
            ("", &["--target"]),
            ("#5fa8c4", &["a colour is given as --target '#5fa8c4'"]),
            ("5fa8c4", &["a colour is given as --target '#5fa8c4'"]),
            ("blue", &["a colour is given as --target '#rrggbb'"]),
            ("#5fa8c4 --thickness 10", &["a colour is given as --target '#5fa8c4'"]),
            ("--target #5fa8c4 --thickness 50000:100000", &["100000 cm", "luminance"]),
            ("--target #000000", &["--target", "#000000", "black"]),
            ("--target blue", &["--target", "blue", "hexadecimal"]),
            ("--target #5fa8c4 --thickness 30:5", &["--thickness", "30", "5", "ascend"]),
            ("--target #5fa8c4 --angle 90", &["angle", "90°", "0–89.99°"]),
            ("--target #5fa8c4 --density 1200", &["density", "1200 kg/m³", "10–900 kg/m³"]),
        ],
    ),
    (
        "swatch -o never.png",
        &[
            ("--rows angle=0,60 --columns angle=1", &["angle", "--rows", "--columns"]),
            ("--columns density=200,1200", &["density", "1200 kg/m³", "10–900 kg/m³"]),
            ("--columns angle=0,95", &["angle", "95°"]),
            ("--columns grain-size=60", &["grain size", "70–4950 µm"]),
            ("--columns depth=1", &["'depth'", "grain-size", "facetness", "density"]),
            ("--columns density=200,400 --density 300", &["density", "--columns", "--density"]),
            ("--rows grain-size=200 --ssa 20", &["--grain-size", "cannot be used with", "--ssa"]),
            ("--columns angle=0,60 --thickness 1,5", &["--thickness", "2"]),
            ("--columns thickness=1,inf", &["thickness is inf cm", "--reflected"]),
            ("--columns angle=0 --exposure inf", &["exposure", "inf stops"]),
            ("--columns angle=0,1,2,3,4,5,6,7,8 --size 2048", &["18432", "16384"]),
            ("--columns angle=0 --colors colours.txt", &["colours.txt", ".csv"]),
            ("--columns thickness=1,5,1", &["thickness 1 is given twice"]),
            ("--density 300", &["--columns"]),
            (
                "--rows grain-size=100,500 --density 300 --snow fresh",
                &["--snow has no effect: ", "--grain-size and --density"],
            ),
        ],
    ),
    (
        "database",
        &[
            ("info no.nc", &["no.nc"]),
            ("build -o t.nc --shard 9/3", &["9/3"]),
            ("build -o t.nc --space log", &["--space", "--components"]),
            ("build -o t.nc --rays 100", &["--rays has no effect: ", "--engine montecarlo"]),
            (
                "build -o t.nc --engine montecarlo --tally-rays 2048",
                &["--tally-rays has no effect: ", "--engine ordinates"],
            ),
            ("build -o t.nc --engine montecarlo --streams 16", &["--streams has no effect: ", "--engine ordinates"]),
            ("fidelity --rays 100", &["--rays has no effect: ", "--engine montecarlo"]),
            ("fidelity none.nc --seed 1", &["--seed has no effect: ", "the table is from a file"]),
            (
                "fidelity --components 32",
                &["invalid value '32' for '--components <", ">': must be a whole number of 1–31\n"],
            ),
            ("export -o snow.xyz", &["snow.xyz", ".csv"]),
        ],
    ),
    (
        "export",
        &[
            ("lut -o snow.png", &["snow.png", ".exr or .json"]),
            ("lut -o t.json --quantity reflectance", &["--quantity has no effect: ", "has both"]),
            ("wgsl -o missing/snow.wgsl", &["missing/snow.wgsl", "folder"]),
            ("wgsl --max-thickness 5000", &["5000 cm", "0.1–1000 cm"]),
            ("wgsl --added-error 0", &["--added-error"]),
            ("wgsl --added-error 0.2", &["--added-error"]),
            ("wgsl --added-error nan", &["--added-error"]),
            ("glsl --density 2000", &["density", "2000 kg/m³", "10–900 kg/m³"]),
            ("openpbr -o snow.xml", &["snow.xml", "must end in .mtlx"]),
            ("arnold -o snow.usda", &["snow.usda", "must end in .mtlx"]),
            ("arnold -o missing/snow.mtlx", &["missing/snow.mtlx", "folder"]),
            ("usd -o snow.usd", &["snow.usd", "must end in .usda"]),
            ("usd --density 5", &["density is 5 kg/m³", "10–900 kg/m³"]),
            ("usd --scene-unit km", &["km", "--scene-unit"]),
            ("principled -o snow.blend", &["snow.blend", "must end in .py"]),
        ],
    ),
    (
        "figures",
        &[
            ("-o figures --only s2,fig99", &["'fig99'", "table1, fig3, fig5-8, fig9, fig10, fig11, s1, lprime, s2"]),
            ("-o pits.csv --only s2", &["pits.csv"]),
            ("-o new/figures --only s2", &["new/figures", "folder"]),
        ],
    ),
    ("render", RENDER),
    (
        "render --scene block_30cm --width 21 --height 14 -o no.exr",
        &[
            (
                "--crop 0:22,0:14",
                &["--crop has the columns 0:22, but the picture has 21 × 14 pixels: columns lie in 0:21"],
            ),
            ("--crop 0:21,3:15", &["--crop has the rows 3:15, but", "rows lie in 0:14"]),
            ("--crop 5:5,0:1", &["--crop", "the columns are '5:5', but must be X0:X1"]),
            ("--crop 5:6", &["--crop", "the rows are missing", "X0:X1,Y0:Y1", "500:516,300:316"]),
            ("--spp-range 0:4294967296", &["--spp-range", "4294967296", "4294967295"]),
            ("--spp-range 0:4 --spp 4", &["--spp-range", "--spp"]),
            ("--aovs distance", &["'distance'", "rgb", "depth"]),
            ("--checkpoint 0", &["--checkpoint", "0 minutes", "0.01–100000 minutes"]),
        ],
    ),
    (
        "render --scene block_30cm --check",
        &[
            ("--spp 4", &["--spp has no effect: ", "--check renders no picture"]),
            ("--integrator hybrid", &["--integrator has no effect: ", "--check renders no picture"]),
        ],
    ),
    (
        "render --scene block_30cm -o no.png",
        &[
            ("--resume", &["--resume", ".exr", "PNG"]),
            ("--keep-sums", &["--keep-sums", ".exr", "PNG"]),
            ("--aovs albedo", &["--aovs", ".exr", "PNG"]),
            ("--aovs normal", &["--aovs", ".exr"]),
            ("--spp 1.5", &["invalid value '1.5' for '--spp <", ">': must be a whole number of 1–16777216\n"]),
            (
                "--seed 4294967296",
                &["invalid value '4294967296' for '--seed <", ">': must be a whole number of 0–4294967295\n"],
            ),
            ("--noise-target 1%", &["invalid value '1%' for '--noise-target <", ">': must be a number of 0.0001–1\n"]),
            ("--field-memory-mib 8", &["'8'", "--field-memory-mib", "a whole number of 16–1048576"]),
            ("--field-step-mm 2000", &["'2000'", "--field-step-mm", "must lie in 0.01–1000 mm"]),
            (
                "--integrator reference --field-step-mm 2",
                &["--field-step-mm has no effect: ", "the integrator reference solves for no light field"],
            ),
            (
                "--path view --field-memory-mib 64",
                &["--field-memory-mib has no effect: ", "the integrator pcasnow solves for no light field"],
            ),
            (
                "--integrator diffusion --path normal",
                &["--path has no effect: ", "the integrator diffusion has no path modes"],
            ),
        ],
    ),
    (
        "bake",
        &[
            ("-o never.glb", &["scene file", "--scene NAME"]),
            ("bare.toml -o a.glb", &["bare.toml", "no snow"]),
            ("--scene block_30cm", &["--output"]),
            ("--scene block_30cm -o snow.obj", &["snow.obj", ".glb or .ply"]),
            ("--scene block_30cm -o snow.glb --spectrum", &["snow.glb", "--spectrum", ".ply"]),
            ("--scene block_30cm -o missing/snow.glb", &["missing/snow.glb", "folder"]),
            ("--scene block_30cm -o a.glb --step-mm 0", &["0 mm", "0.01–100000 mm"]),
            ("--scene block_30cm -o a.glb --field-memory-mib 8", &["'8'", "16–1048576"]),
            ("--scene block_30cm -o a.glb --lightmap 63", &["--lightmap", "63", "64–4096"]),
            ("--scene block_30cm -o a.ply --lightmap 256", &["--lightmap", "a .ply has no preview"]),
            ("--scene block_30cm -o a.ply --exposure 1", &["--exposure has no effect: ", "no preview"]),
        ],
    ),
    (
        "repair",
        &[
            ("sheet.obj -o closed.ply", &["sheet.obj: nothing is inside"]),
            ("sheet.obj -o a.glb", &[".ply, .obj or .stl"]),
            ("sheet.obj -o sheet.obj", &["sheet.obj"]),
            ("gone.ply -o closed.ply", &["gone.ply"]),
        ],
    ),
    ("completions", &[("tcsh", &["'tcsh'", "bash", "zsh"])]),
    ("man", &[("-o a/b", &["a/b"])]),
];

const SPECTRUM: &[(&str, Words)] = &[
    ("--field", &["snowblue: unexpected argument '--field' found\n"]),
    ("--densty 300", &["snowblue: unexpected argument '--densty' found; a similar argument exists: '--density'\n"]),
    ("--density 1200", &["density", "1200 kg/m³", "10–900 kg/m³"]),
    ("--grain-size 60", &["grain size", "70–4950 µm"]),
    ("--optical-radius 1", &["grain size is 2", "20–5000 µm"]),
    ("--optical-radius 100 --ssa 20", &["--optical-radius", "--ssa"]),
    ("--snow slushy", &["slushy", "fresh", "rounded", "faceted", "wind-packed", "melt-forms", "firn"]),
    ("--snow firn --size-measure volume-diameter", &["--size-measure", "--grain-size"]),
    ("--grain-size 300 --density 200 --snow firn", &["--snow has no effect: ", "--grain-size and --density"]),
    ("--water-saturation 1.2", &["water saturation", "1.2", "0–1"]),
    ("--impurity soot=3", &["'soot'", "black-carbon"]),
    ("--impurity black-carbon", &["--impurity", "black-carbon=10"]),
    ("--impurity black-carbon=-3", &["black-carbon is -3 ng/g", "0–10000000 ng/g"]),
    ("--impurity black-carbon=5,black-carbon=50", &["black-carbon", "twice"]),
    ("--thickness 1e99", &["thickness is 1e99 cm", "0–100000 cm"]),
    ("--thickness inf --engine montecarlo", &["thickness is inf cm", "--engine ordinates"]),
    ("--thickness inf --plot x.svg", &["--plot", "half-space"]),
    ("--plot plot.png", &["plot.png", ".svg"]),
    ("-o a.xlsx", &["a.xlsx: the file must end in .csv, .json, .txt or .nc, or give --format"]),
    ("--ground-albedo 1.2", &["ground albedo", "1.2", "0–1"]),
    ("--streams 7", &["7", "even"]),
    ("--streams many", &["--streams", "'many'", "'auto'"]),
    ("--threads 0", &["invalid value '0' for '--threads <", ">': must be a whole number of 1–1024\n"]),
    ("--seed -1", &["invalid value '-1' for '--seed <", ">': must be a whole number of 0–18446744073709551615\n"]),
    (
        "--seed 99999999999999999999",
        &[
            "invalid value '99999999999999999999' for '--seed <",
            ">': must be a whole number of 0–18446744073709551615\n",
        ],
    ),
    (
        "--rays 99999999999999999999",
        &["invalid value '99999999999999999999' for '--rays <", ">': must be a whole number of 2–1000000000000\n"],
    ),
    ("--rays 100", &["--rays has no effect: ", "--engine ordinates"]),
    ("--per-wavelength", &["--per-wavelength has no effect: ", "--engine ordinates"]),
    ("--engine montecarlo --streams auto", &["--streams has no effect: ", "--engine montecarlo"]),
    (
        "--engine montecarlo --per-wavelength --ground-albedo 0.5",
        &["--per-wavelength has no effect: ", "each wavelength has its own rays"],
    ),
    ("--depths 16", &["depth", "16 cm", "0–15 cm"]),
    ("--depths 1 --engine montecarlo", &["--depths", "--engine ordinates"]),
    ("--depths 1 --turbidity 2", &["--sky"]),
    ("--depths 1 --broadband", &["--broadband", "--sky"]),
    ("--wavelengths 100", &["wavelength", "100 nm", "300–2500 nm"]),
    ("--wavelengths 299", &["wavelength", "299 nm", "300–2500 nm"]),
    ("--wavelengths 2501", &["wavelength", "2501 nm", "300–2500 nm"]),
    ("--wavelengths 319 --ice picard2016", &["wavelength", "319 nm", "320–2500 nm"]),
    ("--wavelengths 400:700:10 --broadband", &["320", "400 nm"]),
    ("--wavelengths 400,700 --broadband par", &["400", "700 nm"]),
    ("--wavelengths 700,650 --broadband par", &["ascend"]),
    ("--broadband blue", &["'blue'", "solar, visible, near-infrared, par"]),
    ("--broadband --depths 1", &["--broadband", "--depths"]),
    ("--wavelengths 400:1500:10 --broadband solar", &["320 to 2500 nm", "320 to 400 nm"]),
    ("--depths 1 --plot a.svg", &["--plot has no effect: ", "--depths"]),
    ("--ssa 10,20 --depths 1", &["--depths has no effect: ", "--ssa has several values"]),
    ("--broadband -o grid.nc", &["grid.nc", "NetCDF needs spectra"]),
    ("--plus-minus ssa=2", &["specific surface area", "needs snow"]),
    ("--plus-minus soot=2", &["'soot'", "black-carbon"]),
    ("--plus-minus density=2 --engine montecarlo", &["--plus-minus", "--engine ordinates"]),
];

const RENDER: &[(&str, Words)] = &[
    ("no.toml -o picture.png", &["no.toml"]),
    ("no.toml -o picture.gif", &["picture.gif", ".png", ".exr"]),
    ("latin1.toml -o picture.png", &["latin1.toml:2: the line is not text (UTF-8, or UTF-16 with a byte order mark)"]),
    ("-o never.png", &["scene file", "--scene NAME", "--list-scenes"]),
    ("--scene fig11_dragon -o never.png", &["fig11_dragon", "models/dragon.ply"]),
    ("--scene block -o never.png", &["'block'", "block_30cm", "igloo_clear"]),
    ("a.toml --scene block_30cm -o never.png", &["SCENE", "--scene"]),
    ("--scene block_30cm -o - --checkpoint 1", &["--checkpoint", "file"]),
    ("scene.toml --print", &["--print has no effect: ", "--scene NAME"]),
    ("--list-scenes --width 4", &["--width has no effect: ", "--list-scenes renders no picture"]),
    ("my.toml --list-scenes", &["SCENE has no effect: --list-scenes lists all scenes"]),
];

/// A file that a command reads, and changes that make it wrong.
struct Wrong {
    command: &'static str,
    file: &'static str,
    text: &'static str,
    /// Some text of the file, what takes its place, and what the message names.
    changes: &'static [(&'static str, &'static str, Words)],
}

const WRONG: &[Wrong] = &[
    Wrong {
        command: "spectrum --layers pack.toml",
        file: "pack.toml",
        text: PACK,
        changes: &[
            ("facetness = 0.6", "facetnes = 0.6", &["pack.toml:5: ", "facetnes"]),
            (
                "density_kg_m3 = 120",
                "density_kg_m3 = 1200",
                &["pack.toml:6: ", "density", "1200 kg/m³", "10–900 kg/m³"],
            ),
            ("density_kg_m3 = 120", "density_kg_m3 = \"light\"", &["pack.toml:6: ", "light"]),
            (
                "density_kg_m3 = 120",
                "density_kg_m3 = 917",
                &["pack.toml:6: ", "layer[0].density_kg_m3 is 917 kg/m³", "kind = \"ice\""],
            ),
            ("[100, 200]", "[200, 100]", &["pack.toml:4: ", "grain_size_um", "200", "100"]),
            ("[100, 200]", "60", &["pack.toml:4: ", "grain_size_um", "70–4950 µm"]),
            ("[100, 200]", "true", &["pack.toml:4: ", "number"]),
            ("facetness = 0.6", "facetness = 1.6", &["pack.toml:5: ", "facetness", "1.6", "0–1"]),
            ("sphericity = [0.6, 0.9, 0.7, 0.1]", "sphericity = 0.3", &["pack.toml:10: ", "sphericity", "0.3"]),
            ("ssa_m2_kg = 12", "ssa_m2_kg = 12\ngrain_size_um = 300", &["pack.toml:9: ", "ssa_m2_kg", "grain size"]),
            ("thickness_cm = 8.5", "thickness_cm = -1", &["pack.toml:8: ", "thickness", "-1 cm"]),
            ("thickness_cm = 8.5", "", &["pack.toml:7: ", "thickness_cm"]),
            (
                "thickness_cm = 2\n",
                "thickness_cm = inf\n",
                &["pack.toml:3: ", "layer[0].thickness_cm is inf cm", "0–100000 cm"],
            ),
            ("picard2016", "hale1973", &["pack.toml:1: ", "hale1973", "picard2016"]),
            ("[[layer]]", "[[layer]", &["pack.toml:2: ", "unclosed"]),
            (
                "[[layer]]\nthickness_cm = 8.5",
                "[[layer]]\nkind = \"ice\"\nthickness_cm = 1\nssa_m2_kg = 20\n[[layer]]\nthickness_cm = 8.5",
                &["pack.toml:10: ", "ssa_m2_kg is a property of snow"],
            ),
            (
                "[[layer]]\nthickness_cm = 8.5",
                "[[layer]]\nkind = \"ice\"\nthickness_cm = 0.001\n[[layer]]\nthickness_cm = 8.5",
                &["pack.toml:9: ", "layer[1].thickness_cm is 0.001 cm", "0.01–100000 cm"],
            ),
            (PACK, "", &["pack.toml", "[[layer]]"]),
        ],
    },
    Wrong {
        command: "spectrum --wavelengths 500 --layers pack.toml",
        file: "pack.toml",
        text: "[[layer]]\nthickness_cm = 2\nsnow = \"fresh\"\nimpurities_ng_g = { black-carbon = 20 }\n\
               [[layer]]\nthickness_cm = 10\nsnow = \"melt-forms\"\nwater_saturation = 0.05\n",
        changes: &[
            ("black-carbon", "soot", &["pack.toml:4:", "'soot'"]),
            ("= 20 }", "= -20 }", &["pack.toml:4:", "-20 ng/g"]),
            ("0.05", "1.05", &["pack.toml:8:", "1.05"]),
            ("melt-forms", "melting", &["pack.toml:7:", "`melting`", "`melt-forms`"]),
        ],
    },
    Wrong {
        command: "spectrum --batch pits.csv -o pits.nc",
        file: "pits.csv",
        text: PITS,
        changes: &[
            (
                GLACIER,
                "steep,25,1200,0,1,0",
                &["pits.csv:5: density_kg_m3: density is 1200 kg/m³, but must lie in 10–900 kg/m³"],
            ),
            (GLACIER, "deep,25,300,0,-1,0", &["pits.csv:5: thickness is -1 cm"]),
            (GLACIER, "bright,25,300,0,1,2", &["pits.csv:5: ground albedo is 2"]),
            (GLACIER, "fine,400,300,0,1,0", &["pits.csv:5: ssa_m2_kg: specific surface area is 400 m²/kg"]),
            (GLACIER, "word,many,300,0,1,0", &["pits.csv:5: ssa_m2_kg: 'many' is not a number"]),
            (GLACIER, "short,25", &["pits.csv:5: has 2 cells, but there are 6 columns"]),
            (PITS, "name,ssa\na,20\n", &["pits.csv:1: column 'ssa' is not known; there are name", "ssa_m2_kg"]),
            (
                PITS,
                "# pits\nname;ssa_m2_kg\na;20\n",
                &["pits.csv:2: column 'name;ssa_m2_kg' is not known: columns", "has semicolons"],
            ),
            (PITS, "name\tssa_m2_kg\n", &["pits.csv:1: ", "columns are separated by commas", "has tabs"]),
            (
                PITS,
                "ssa_m2_kg\n20;5\n",
                &["pits.csv:2: ssa_m2_kg: '20;5' is not a number: columns are separated by commas"],
            ),
            (
                PITS,
                "ssa_m2_kg,thickness_cm\n20,5,3\n",
                &[
                    "pits.csv:2: has 3 cells, but there are 2 columns",
                    "decimals have a point, but this line has more commas",
                ],
            ),
            (PITS, "name,snow,name\n", &["pits.csv:1: column name is given twice"]),
            (PITS, "name,snow\n", &["pits.csv: has no slab"]),
            (PITS, "", &["pits.csv: has no line of names"]),
            (PITS, "ssa_m2_kg,grain_size_um\n20,300\n", &["pits.csv:2: ssa_m2_kg cannot be given with grain_size_um"]),
            (
                PITS,
                "size_measure,grain_size_um,optical_radius_um\n,300,50\n",
                &["pits.csv:2: grain_size_um cannot be given with optical_radius_um"],
            ),
            (
                PITS,
                "size_measure,grain_size_um,optical_radius_um\nvolume-diameter,,50\n",
                &["pits.csv:2: size_measure cannot be given with optical_radius_um"],
            ),
        ],
    },
    Wrong {
        command: "color --spectrum half.csv",
        file: "half.csv",
        text: "wavelength_nm,value\n",
        changes: &[
            ("value\n", "value\n", &["half.csv:", "spectrum"]),
            (HALF, "450,0.5\n550,0.5\n650,0.5\n", &["half.csv:1:", "step", "450", "550 nm", "20 nm"]),
            (
                HALF,
                "400,0.5\n420,0.5\n430,0.5\n450,0.5\n",
                &["half.csv:1:", "wavelengths", "400–450 nm", "cover", "400–700 nm"],
            ),
            (HALF, "500,0.5\n510,0.5\n520,0.5\n", &["half.csv:1:", "wavelengths", "500–520 nm", "cover", "400–700 nm"]),
            (
                HALF,
                "# measured\n400;0.5\n",
                &["half.csv:2: expected a wavelength", "400;0.5", "this line has semicolons"],
            ),
            (HALF, "400,0.5\n410,0,5\n", &["half.csv:2:", "decimals have a point, but this line has more commas"]),
        ],
    },
    Wrong {
        command: "database build --axes axes.toml -o table.nc",
        file: "axes.toml",
        text: AXES,
        changes: &[
            ("\"diffuse\"", "\"difuse\"", &["axes.toml:5:", "'difuse'"]),
            ("[1, 10]", "[10, 1]", &["axes.toml:", "thickness"]),
            ("black-carbon", "soot", &["axes.toml:9:", "impurities_ng_g.soot", "black-carbon"]),
            ("preset", "presets", &["axes.toml:1:", "presets"]),
            ("[0, 0.2]", "[0, 1.2]", &["axes.toml:", "1.2"]),
            ("400:700:50", "400:2600:50", &["axes.toml:", "2550 nm", "300–2500 nm"]),
        ],
    },
    Wrong {
        command: "render box.toml --check",
        file: "box.toml",
        text: BOX,
        changes: &[
            ("\"box\"\nsize = [1, 1, 1]", "\"igloo\"\nwall = 3", &["box.toml:", "wall", "3 m", "0.75 m"]),
            ("\"box\"", "\"igloo\"", &["box.toml:", "size"]),
            ("\"box\"\nsize = [1, 1, 1]", "\"igloo\"\nseam_depth = 0.1", &["box.toml:", "seam_depth", "0.1 m"]),
            (
                "\"box\"\nsize = [1, 1, 1]",
                "\"drift\"\nsize = [1, 1, 0.2]\nmounds = [[0, 0, 1]]",
                &["box.toml:", "mounds"],
            ),
            (
                "\"box\"\nsize = [1, 1, 1]",
                "\"drift\"\nsize = [1, 1, 0.2]\nmounds = [[0, 0, 1, 0]]",
                &["box.toml:", "mounds"],
            ),
            (
                "\"box\"\nsize = [1, 1, 1]",
                "\"drift\"\nsize = [1, 1, 0.01]\nrelief = 0.5",
                &["box.toml:", "-0.01 m", "height"],
            ),
        ],
    },
    Wrong {
        command: "repair fins.obj -o closed.ply",
        file: "fins.obj",
        // Three triangles at one edge.
        text: FINS,
        changes: &[
            (FINS, FINS, &["fins.obj: ", "edges are still open"]),
            (FINS, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", &["fins.obj: nothing is inside"]),
        ],
    },
    Wrong {
        command: "render scene.toml -o picture.png",
        file: "scene.toml",
        text: BLOCK,
        changes: &[
            ("facetness = 0.3", "facetnes = 0.3", &["scene.toml:", "facetnes"]),
            ("shape = \"box\"\nsize = [0.6, 0.3, 0.6]", "mesh = \"none.ply\"", &["none.ply"]),
            ("shape = \"box\"\nsize = [0.6, 0.3, 0.6]", "mesh = \"cut.ply\"", &["cut.ply"]),
            ("shape = \"box\"\nsize = [0.6, 0.3, 0.6]", "mesh = \"cut.glb\"", &["cut.glb", "glTF"]),
        ],
    },
];

const GLACIER: &str = "glacier,3,,400,40,0";
const HALF: &str = "wavelength_nm,value\n";
const FINS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n";

/// A scene of a snowy box.
const BOX: &str = "[camera]\nposition = [0, -9, 9]\nlook_at = [0, 0, 0]\n[environment]\nradiance_w_m2_sr = 1\n\
    [material.snow]\ntype = \"snow\"\ngrain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n\
    [[object]]\nmaterial = \"snow\"\nshape = \"box\"\nsize = [1, 1, 1]\n";

#[test]
fn each_wrong_command_line_is_refused() {
    let folder = Folder::new();
    for (name, content) in FILES {
        folder.write(name, content);
    }
    for (command, refusals) in LINES {
        for (rest, words) in *refusals {
            folder.assert_refused(&format!("{command} {rest}"), words);
        }
    }
}

#[test]
fn each_wrong_file_is_refused() {
    let folder = Folder::new();
    for (name, content) in FILES {
        folder.write(name, content);
    }
    for Wrong { command, file, text, changes } in WRONG {
        for (from, to, words) in *changes {
            assert!(text.contains(from), "{file} has no '{from}'");
            folder.write(file, text.replacen(from, to, 1));
            folder.assert_refused(command, words);
        }
    }
}

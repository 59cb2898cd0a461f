//! Options of snow: kinds, water and impurities.

use snowblue_transport::sample::Property;

use crate::shell::{BLOCK, Folder, assert_names, stderr, stdout};

/// A kind of snow at a temperature is the same in a file of layers and as options.
#[test]
fn layers_and_options_mean_the_same_snow() {
    let folder = Folder::new();
    folder.write("pack.toml", "[[layer]]\nthickness_cm = 5\nsnow = \"firn\"\ntemperature_c = -60\n");
    let layered = folder.stdout("spectrum --wavelengths 450 --layers pack.toml");
    let alone = transmittance("--snow firn --temperature -60");
    assert!((last_row(&layered, 4)[0] / alone - 1.0).abs() < 1e-8, "{layered} {alone}");
}

/// The last row's numbers from the given column on.
fn last_row(text: &str, from: usize) -> Vec<f64> {
    text.lines().last().unwrap().split(',').skip(from).map(|field| field.parse().unwrap()).collect()
}

fn transmittance(options: &str) -> f64 {
    last_row(&stdout(&format!("spectrum --wavelengths 450 --thickness 5 {options}")), 4)[0]
}

#[test]
fn kinds_of_snow_set_surface_area_and_density() {
    let kind = transmittance("--snow rounded");
    let numbers = transmittance("--ssa 25 --density 250");
    assert!((kind / numbers - 1.0).abs() < 1e-9, "{kind} {numbers}");
    // Given quantities override those of the kind.
    assert!(transmittance("--snow rounded --density 500") < 0.7 * kind);
    assert!(transmittance("--snow rounded --grain-size 2000") > 2.0 * kind);
    assert!(transmittance("--snow fresh") < transmittance("--snow melt-forms"));
}

#[test]
fn water_transmits_blue_and_soot_absorbs_it() {
    let dry = transmittance("");
    assert!(transmittance("--water-saturation 0.3 --streams 16") > 1.2 * dry);
    let sooty = transmittance("--impurity black-carbon=100");
    // σ_a = 0.24/m more, κ(1 − g) = 500/m: x/sinh x with x = 0.05 √(3 · 0.24 · 500) = 0.95 is 0.87.
    assert!((sooty / dry - 0.87).abs() < 0.03);
    let both = transmittance("--impurity black-carbon=100,saharan-dust=500");
    let underscores = transmittance("--impurity black_carbon=100,saharan_dust=500");
    assert_eq!(underscores.to_bits(), both.to_bits());
    let repeated = transmittance("--impurity saharan-dust=500 --impurity black-carbon=100");
    assert!(both < sooty && (both / repeated - 1.0).abs() < 1e-12);
}

#[test]
fn metadata_describe_the_snow() {
    let options = "--snow firn --water-saturation 0.1 --impurity snow-algae=2e4 --streams 16";
    let words = ["Cuffey & Paterson", "saturation 0.1", "snow-algae=20000 ng/g (Chevrollier et al. 2023"];
    assert_names(&stderr(&format!("spectrum --wavelengths 500 {options}")), &words);
}

#[test]
fn layers_can_differ_in_composition() {
    let folder = Folder::new();
    let pack = "[[layer]]\nthickness_cm = 2\nsnow = \"fresh\"\nimpurities_ng_g = { black-carbon = 20 }\n\
                [[layer]]\nthickness_cm = 10\nsnow = \"melt-forms\"\nwater_saturation = 0.05\n";
    let reflectance = |pack: &str| {
        folder.write("pack.toml", pack);
        last_row(&folder.stdout("spectrum --wavelengths 500 --layers pack.toml"), 3)[0]
    };
    // Soot in the top layer absorbs blue light that clean snow reflects.
    let (sooty, clean) = (reflectance(pack), reflectance(&pack.replace("= 20 }", "= 0 }")));
    assert!(sooty < clean - 5e-4, "{sooty} {clean}");
}

/// The CSV of an option and the table of a layer file and of a scene declare the same particles, which darken snow.
#[test]
fn particles_may_have_a_table_of_their_own() {
    let folder = Folder::new();
    folder.write(
        "dust.csv",
        "wavelength_nm,extinction_m2_kg,single_scattering_albedo,asymmetry\n\
                              300,800,0.8,0.7\n2500,400,0.9,0.6\n",
    );
    let table = "[substance.my-dust]\nwavelength_nm = [300, 2500]\nextinction_m2_kg = [800, 400]\n\
                 single_scattering_albedo = [0.8, 0.9]\nasymmetry = [0.7, 0.6]\n";
    let snow = "impurities_ng_g = { my-dust = 1000 }\n";
    folder.write("pack.toml", format!("{table}[[layer]]\nthickness_cm = 5\n{snow}"));
    let wavelengths = "--wavelengths 450,700";
    let option = folder.stdout(&format!("spectrum {wavelengths} --thickness 5 --impurity my_dust=1000:dust.csv"));
    let layers = folder.stdout(&format!("spectrum {wavelengths} --layers pack.toml"));
    let (by_option, in_layers) = (last_row(&option, 3), last_row(&layers, 3));
    assert!((by_option[0] - in_layers[0]).abs() < 1e-6, "{option} {layers}");
    let clean = folder.stdout(&format!("spectrum {wavelengths} --thickness 5"));
    assert!(by_option[0] < last_row(&clean, 3)[0] - 1e-4, "{option} {clean}");
    let block = BLOCK.replacen("density_kg_m3 = 300\n", &format!("density_kg_m3 = 300\n{snow}"), 1);
    folder.write("scene.toml", format!("{block}\n{table}"));
    folder.stdout("render scene.toml --check");
    folder.write("short.csv", "wavelength_nm,absorption_m2_kg\n400,9000\n700,5000\n");
    folder.write("twice.csv", "400,9000\n400,5000\n");
    folder.write("white.csv", "wavelength_nm,extinction_m2_kg,single_scattering_albedo,asymmetry\n400,800,1.1,0.7\n");
    for (words, expected) in [
        ("--impurity soot=9:short.csv --broadband solar", "wavelength in snow with soot is 320 nm"),
        ("--impurity soot=9:twice.csv", "twice.csv:2: wavelength is 400 nm, but must lie above 400 nm"),
        ("--impurity soot=9:white.csv", "white.csv:2: single-scattering albedo is 1.1, but must lie in 0–1"),
        ("--impurity soot=9:none.csv", "none.csv: cannot be read"),
        ("--impurity black-carbon=9:short.csv", "the name is taken by a built-in substance"),
    ] {
        folder.assert_refused(&format!("spectrum {words}"), &[expected]);
    }
}

/// Also with the rows of tests: `--features snowblue-transport/test-rows`.
#[test]
fn every_property_is_in_options_batches_swatches_layers_and_scenes() {
    const OWN_SNOW: &str = "grain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n";
    let folder = Folder::new();
    let help = stdout("spectrum --help");
    let id = |options: &str| {
        let log = stderr(&format!("spectrum --wavelengths 500 --thickness 1 {options}"));
        log.lines().find(|line| line.contains("snow_id")).unwrap_or_else(|| panic!("{log}")).to_owned()
    };
    let usual = id("");
    assert!(BLOCK.contains(OWN_SNOW));
    for property in Property::all() {
        let (key, name, parameter) = (property.key(), property.name().replace('_', "-"), property.parameter());
        let value = parameter.default + 0.125 * (parameter.range.greatest.min(1000.0) - parameter.default);
        let line = match property {
            Property::Impurity(substance) => {
                assert_ne!(id(&format!("--impurity {substance}={value}")), usual);
                assert!(help.contains(substance.name()), "{name} in {help}");
                format!("impurities_ng_g = {{ {substance} = {value} }}\n")
            }
            _ => {
                assert_ne!(id(&format!("--{name} {value}")), usual);
                assert!(help.contains(&format!("--{name}")), "{name} in {help}");
                folder.stdout(&format!("swatch --size 16 --rows {name}={value} -o a.png"));
                format!("{key} = {value}\n")
            }
        };
        folder.write("slabs.csv", format!("{key}\n{value}\n"));
        let slabs = folder.stdout("spectrum --wavelengths 500 --thickness 1 --batch slabs.csv");
        assert!(slabs.lines().any(|line| line.starts_with(key)), "{key} in {slabs}");
        folder.write("pack.toml", format!("[[layer]]\nthickness_cm = 1\n{line}"));
        folder.stdout("spectrum --wavelengths 500 --layers pack.toml");
        folder.write("scene.toml", BLOCK.replacen(OWN_SNOW, &line, 1));
        folder.stdout("render scene.toml --check");
    }
}

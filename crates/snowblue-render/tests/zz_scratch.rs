mod snow;
use snowblue_render::{Integrator, Preparation, SceneFile};
#[test]
fn messages() {
    for (keys, extra) in [
        ("facetnes = 0.3", ""), ("density_kg_m3 = 1200", ""), ("density_kg_m3 = nan", ""), ("density_kg_m3 = \"300\"", ""),
        ("grain_size_um = 4", ""), ("grain_size_um = 5000", ""), ("grain_size_um = [500, 100]", ""), ("grain_size_um = [1, 2, 3]", ""), ("grain_size_um = []", ""), ("grain_size_um = \"fine\"", ""),
        ("snow = \"powder\"", ""), ("snow = 3", ""), ("ssa_m2_kg = 1000", ""), ("ssa_m2_kg = 20\ngrain_size_um = 400", ""),
        ("size_measure = \"radius\"", ""), ("facetness = 2", ""), ("facetness = [0, 1, 0.5]", ""), ("sphericity = 0.1", ""), ("water_saturation = 2", ""),
        ("temperature_c = 5", ""), ("ice = \"snow\"", ""), ("impurities_ng_g = { soot = 5 }", ""), ("impurities_ng_g = { black-carbon = -5 }", ""), ("impurities_ng_g = 5", ""), ("impurities_ng_g = { black-carbon = \"a\" }", ""),
        ("impurities_ng_g = { black-carbon = [1, 2] }", ""),
        ("layers = \"a.toml\"\ngrain_size_um = 3", ""), ("layers = \"a.toml\"\nwater_saturation = 0.1", ""), ("layers_top = 3", ""), ("layers = \"a.toml\"", ""),
        ("mask = { attribute = \"age\" }", ""), ("between = [{}, {}]", ""), ("mask = { attribute = \"age\" }\nbetween = [{}]", ""), ("mask = { attribute = \"age\" }\nbetween = [{}, {}, {}]", ""),
        ("mask = { attribute = \"age\" }\nbetween = 3", ""), ("mask = { attribute = \"age\" }\nbetween = [{}, { density = 3 }]", ""),
        ("mask = { attribute = \"age\" }\nbetween = [{}, { density_kg_m3 = 3 }]", ""),
        ("mask = { attribute = \"age\" }\nbetween = [{}, { impurities_ng_g = { soot = 3 } }]", ""),
        ("mask = { attribute = \"age\" }\nbetween = [{}, { snow = \"fresh\" }]", ""),
        ("mask = { attribute = \"age\" }\nbetween = [{}, { ice = \"warren-1984\" }]", ""),
        ("mask = { attribute = \"age\" }\nbetween = [{}, {}]\ngrain_size_um = 400", ""),
        ("mask = { attribute = \"age\" }\nbetween = [{}, {}]\nwater_saturation = 0.1", ""),
        ("mask = { attribute = \"age\", range = [1, 1] }\nbetween = [{}, {}]", ""),
        ("mask = { attribute = \"age\", texture = \"a.png\" }\nbetween = [{}, {}]", ""),
        ("mask = 3\nbetween = [{}, {}]", ""),
        ("mask = { attribute = \"age\" }\nbetween = [{}, {}]", ""),
        ("path = \"normal\"", ""), ("reflectance = 0.5", ""), ("table = \"a.nc\"", ""),
        ("", "[integrator.pcasnow]\npath = \"shortest\""), ("", "[integrator.pcasnow]\nreflectance = 1.5"), ("", "[integrator.pcasnow]\nemission = 3"), ("", "[integrator.pcasnow]\nexit = \"a\""), ("", "[integrator.pcasnow]\nexits = \"a\""),
        ("", "[integrator.pcasnow]\ntable = \"gone.nc\""), ("", "[film]\nfalse_color = { red_nm = 2600, green_nm = 500, blue_nm = 400 }"), ("", "[film]\nfalse_color = { red_nm = 1600, green_nm = 500 }"),
        ("ice = \"picard-2016\"", "[film]\nfalse_color = { red_nm = 2500, green_nm = 500, blue_nm = 300 }"),
        ("temperature_c = -60", "[film]\nfalse_color = { red_nm = 2500, green_nm = 500, blue_nm = 300 }"),
    ] {
        let text = format!("[camera]\nposition = [0, -9, 0]\nlook_at = [0, 0, 0]\n[integrator]\ntype = \"pcasnow\"\n[environment]\nradiance_w_m2_sr = 1\n[material.snow]\ntype = \"snow\"\n{keys}\n[[object]]\nshape = \"box\"\nsize = [1, 1, 1]\nmaterial = \"snow\"\n{extra}\n");
        let r = SceneFile::parse(text, "scene.toml").map_err(|e| e.to_string()).and_then(|f| {
            let s = f.build().map_err(|e| e.to_string())?;
            Integrator::prepare_with(&s, Preparation::default()).map(|i| i.notes().to_vec()).map_err(|e| f.locate(e).to_string())
        });
        println!("{:60} {extra:30} -> {r:?}", keys.replace('\n', "; "));
    }
}

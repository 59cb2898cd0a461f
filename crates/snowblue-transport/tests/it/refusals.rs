//! What the engines refuse, with their messages. Those of retrievals stand with them.

use snowblue_transport::batch::{Batch, SlabCase};
use snowblue_transport::monte_carlo::{self, GoniometricOptions, PatchGrid};
use snowblue_transport::ordinates::{OrdinatesOptions, differentiate_batch};
use snowblue_transport::{
    IceTable, Impurities, Incidence, Layer, LayerVariable, Property, Slab, SnowSample, Stack, Substance, Variable,
};

const BEAM: Incidence = Incidence::Beam { angle_deg: 30.0 };
const SOOT: Variable = Variable::impurity(Substance::BLACK_CARBON);
const OPTIONS: fn() -> OrdinatesOptions = || OrdinatesOptions { tally_rays: 64, ..OrdinatesOptions::default() };

fn wet(water_saturation: f64) -> SnowSample {
    SnowSample { water_saturation, ..SnowSample::default() }
}

fn sooty(ng_g: f64) -> SnowSample {
    SnowSample { impurities: Impurities::none().with(Substance::BLACK_CARBON, ng_g), ..SnowSample::default() }
}

fn slab(sample: SnowSample, wavelength_nm: f64) -> Slab {
    Slab { sample, thicknesses_cm: vec![1.0], incidences: vec![BEAM], wavelengths_nm: vec![wavelength_nm] }
}

fn stack(layers: Vec<Layer>, wavelength_nm: f64) -> Stack {
    Stack {
        layers,
        ground_albedo: 0.0.into(),
        depths_cm: vec![],
        incidences: vec![BEAM],
        wavelengths_nm: vec![wavelength_nm],
    }
}

fn told<T>(answer: Result<T, impl ToString>) -> Result<(), String> {
    answer.map(drop).map_err(|refusal| refusal.to_string())
}

#[test]
fn refusals_name_the_quantity_its_value_and_its_range() {
    let snow = SnowSample::default();
    let case = SlabCase { sample: 0, thickness_cm: 1.0, incidence: BEAM, ground_albedo: 0.0.into() };
    let batch = Batch { samples: vec![snow], cases: vec![case], wavelengths_nm: vec![300.0] };
    let slab_by = |variable| differentiate_batch(&batch, &[variable], &OPTIONS(), false, &|_| ());
    let of_ice = stack(vec![Layer::ice(IceTable::default(), 1.0), Layer::ice(IceTable::Picard2016, 1.0)], 500.0);
    let message = "ice table of neighbouring layers of ice must be one, as they are one slab";
    assert_eq!(told(of_ice.check()), Err(message.to_owned()));
    // Tables of water and soot cover the wavelengths of the model.
    for sample in [wet(0.1), sooty(1.0)] {
        assert_eq!(told(slab(sample, 300.0).check()).and(told(slab(sample, 2500.0).check())), Ok(()));
    }
    assert_eq!(told(slab_by(SOOT)), Ok(()));
    assert_eq!(told(slab_by(Variable::Snow(Property::Density))), Ok(()));
    assert_eq!(LayerVariable { variable: SOOT, layer: Some(2) }.to_string(), "black-carbon of layer 2");
}

#[test]
fn grids_of_patches_out_of_range_are_refused() {
    for (rings, sectors) in [(0, 1), (1, 0), (1001, 1), (1, 361)] {
        let options = GoniometricOptions { rays: 10, seed: 1, patches: PatchGrid { rings, sectors } };
        let slab = slab(SnowSample::default(), 550.0);
        assert!(monte_carlo::distribute(&slab, &options, &|_| ()).is_err(), "{rings} {sectors}");
    }
}

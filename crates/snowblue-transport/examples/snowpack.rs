//! Prints the fluxes at several depths of a snowpack on dark soil, under diffuse light of 450 nm and of 700 nm:
//! `cargo run -p snowblue-transport --example snowpack`.

#![allow(clippy::print_stdout, reason = "the example prints its result")]

use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::sample::SnowType;
use snowblue_transport::{Impurities, Incidence, Layer, SnowSample, Stack, Substance, TransportError};

fn main() -> Result<(), TransportError> {
    let black_carbon = Impurities::none().with(Substance::BLACK_CARBON, 20.0);
    let stack = Stack {
        layers: vec![
            Layer::snow(SnowType::Fresh.sample()?, 3.0),
            Layer::snow(SnowSample { impurities: black_carbon, ..SnowType::WindPacked.sample()? }, 5.0),
            Layer::snow(SnowType::Rounded.sample()?, 12.0),
        ],
        ground_albedo: 0.15.into(),
        depths_cm: vec![0.0, 1.0, 3.0, 8.0, 20.0],
        incidences: vec![Incidence::Diffuse],
        wavelengths_nm: vec![450.0, 700.0],
    };
    for result in ordinates::solve_stack(&stack, &OrdinatesOptions::default())? {
        println!("{} nm: albedo {:.4}", result.whole.wavelength_nm, result.whole.fluxes.reflectance.value);
        println!("   depth      down        up    e-folding depth");
        for (depth_cm, at) in stack.depths_cm.iter().zip(&result.profile) {
            println!(
                "{depth_cm:5} cm {:9.5} {:9.5} {:12.1} cm",
                at.down.value, at.up.value, at.e_folding_depth_cm.value
            );
        }
    }
    Ok(())
}

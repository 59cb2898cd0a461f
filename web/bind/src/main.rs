//! Makes the JavaScript module of a WebAssembly file: `bind WASM FOLDER NAME` writes `NAME.js` and `NAME_bg.wasm`.
//!
//! It replaces the program wasm-bindgen, which must have exactly the version of the library.

use std::error::Error;

use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [wasm, folder, name] = &arguments[..] else { return Err("usage: bind WASM FOLDER NAME".into()) };
    let mut bindgen = Bindgen::new();
    bindgen.input_path(wasm).out_name(name).web(true)?.typescript(true).omit_default_module_path(false);
    // The names of functions are an eighth of a module, and browsers do not keep files above 6.25 MiB in memory.
    bindgen.remove_name_section(true);
    Ok(bindgen.generate(folder)?)
}

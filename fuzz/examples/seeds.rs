//! Writes what the fuzzer starts from into `corpus/TARGET/`.
//!
//!     cargo run --release --example seeds     (from the folder fuzz)

use std::fs;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (target, name, bytes) in harmolux_fuzz::seeds(&here.join(".."))? {
        let folder = here.join("corpus").join(target);
        fs::create_dir_all(&folder)?;
        fs::write(folder.join(name), bytes)?;
    }
    Ok(())
}

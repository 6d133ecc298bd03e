// Many instances side by side, as in docs/rust.md, where it stands; a test runs it.

use rom_runtime::{Batch, Model, Settings};
use std::sync::Arc;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Arc::new(Model::read_path("hale.rom")?);
    let mut batch = Batch::new(model.clone(), Settings::default(), 64)?;
    for index in 0..batch.len() {
        let mut start = batch.state(index).ok_or("no such instance")?;
        start.q_dot[0] = 0.01 * index as f64;
        start.accelerations_known = false; // changed by hand: they are solved anew
        batch.restore(index, &start)?;
    }
    let gust = model.prepare(model.load_case("gust")?)?;
    let loads = vec![&gust; batch.len()];
    for _ in 0..100 {
        batch.step(&loads)?;
    }
    Ok(())
}

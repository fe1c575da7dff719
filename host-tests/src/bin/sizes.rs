//! Prints the flash that the core takes on every target: `cargo run --release -p quadcal-host-tests --bin sizes`.

use quadcal_host_tests::firmware::{FirmwareError, TARGETS, sizes};

fn main() -> Result<(), FirmwareError> {
    println!(
        "| processor | target | correct: `.text` | `.rodata` | correct and learn: `.text` | `.rodata` |"
    );
    println!("|---|---|---|---|---|---|");
    for target in &TARGETS {
        let (name, triple) = (target.processor, target.triple);
        let sizes = sizes(target)?;
        let [text, rodata, learn_text, learn_rodata] = [
            sizes.correct.text,
            sizes.correct.rodata,
            sizes.learn.text,
            sizes.learn.rodata,
        ];
        println!("| {name} | `{triple}` | {text} | {rodata} | {learn_text} | {learn_rodata} |");
    }
    Ok(())
}

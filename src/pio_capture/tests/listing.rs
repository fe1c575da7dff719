//! The words of the program are those of its text.

use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

use super::program::{CAPTURES, TELLS, WORDS};

/// Instructions of the text, with addresses for labels, and where the loops are.
fn text() -> (Vec<String>, Vec<u32>, Vec<u32>) {
    let lines = include_str!("../program.pio").lines();
    let lines = lines.map(|line| line.split(';').next().unwrap_or_default().trim());
    let (mut code, mut labels) = (Vec::new(), Vec::new());
    let (mut bottoms, mut tops) = (Vec::new(), Vec::new());
    for line in lines.filter(|line| !line.is_empty()) {
        let at = code.len() as u32;
        match (line, line.strip_suffix(':')) {
            (".wrap_target", _) => bottoms.push(at),
            (".wrap", _) => tops.push(at - 1),
            (".program quadcal", _) => {}
            (_, Some(label)) => labels.push((label, at)),
            _ => code.push(line),
        }
    }
    let code = code.into_iter().map(|line| {
        let words = line.split_whitespace().map(|word| {
            let label = labels.iter().find(|(label, _)| *label == word);
            label.map_or(word.to_string(), |(_, at)| at.to_string())
        });
        words.collect::<Vec<_>>().join(" ")
    });
    (code.collect(), bottoms, tops)
}

/// An instruction as the text has it ("PIO: instruction set" in both data sheets).
fn disassembled(word: u16) -> String {
    let (field, low, delay) = (word >> 5 & 7, word & 31, word >> 8 & 31);
    let place =
        |code: u16| ["pins", "x", "y", "null", "?", "status", "isr", "osr"][usize::from(code)];
    let plain = match (word >> 13, field) {
        (0, _) => {
            let when = ["", "!x", "x--", "!y", "y--", "x!=y", "pin", "!osre"][usize::from(field)];
            format!("jmp {when} {low}")
        }
        (2, _) => format!("in {}, {low}", place(field)),
        (3, _) => format!("out {}, {low}", place(field)),
        (4, 0) => "push noblock".to_string(),
        (4, 4) => "pull noblock".to_string(),
        (5, _) => {
            let invert = if low >> 3 == 1 { "~" } else { "" };
            format!("mov {}, {invert}{}", place(field), place(low & 7))
        }
        _ => format!("{word:04X}"),
    };
    if delay == 0 {
        plain
    } else {
        format!("{plain} [{delay}]")
    }
}

#[test]
fn the_words_are_those_of_the_text() {
    let (code, bottoms, tops) = text();
    let words: Vec<_> = WORDS.into_iter().map(disassembled).collect();
    assert_eq!(words, code);
    assert_eq!(
        (bottoms, tops),
        ([CAPTURES.bottom].to_vec(), [CAPTURES.top].to_vec())
    );
    // A text has one loop; the other one is between labels.
    assert_eq!(TELLS.top as usize, WORDS.len() - 1);
    assert_eq!(code[TELLS.bottom as usize], "jmp x-- 17 [3]");
    assert_eq!(code[CAPTURES.entry as usize], "mov osr, pins");
}

#[test]
fn the_first_registers_are_all_ones() {
    let ones = [
        super::program::ISR_ONES,
        super::program::X_ONES,
        super::program::Y_ONES,
    ];
    let text = ones.map(|word| disassembled(word as u16));
    assert_eq!(text, ["mov isr, ~null", "mov x, ~null", "mov y, ~null"]);
}

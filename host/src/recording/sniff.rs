//! Which format a recording has, from its first bytes and its extension.

use std::sync::Arc;

use super::columns::{delimiter, found, names};
use super::decimal;
use super::error::ReadError;
use super::list;
use super::logic::is_time;
use super::options::{Format, ReadOptions, Signal};
use super::place::Place;

/// Bytes that are looked at.
pub(super) const HEAD: usize = 64 * 1024;

/// The format of a file that begins with `head`.
pub(super) fn format(
    head: &[u8],
    file: &Arc<str>,
    options: &ReadOptions,
) -> Result<Format, ReadError> {
    let whole = Place::file(file);
    if head.starts_with(b"PK\x03\x04") {
        return Err(ReadError::UnknownFormat {
            at: whole,
            found: "a zip archive (a sigrok session is one; export it as CSV or VCD)".to_owned(),
        });
    }
    if head.trim_ascii().is_empty() {
        return Err(ReadError::Empty { at: whole });
    }
    if memchr::memchr(0, head).is_some() {
        let lines_before = head
            .iter()
            .take_while(|&&b| b != 0)
            .filter(|&&b| b == b'\n')
            .count() as u64;
        return Err(ReadError::NotText {
            at: Place::line(file, lines_before + 1),
        });
    }
    if let Some(format) = options.format {
        return Ok(format);
    }
    let extension = file.rsplit_once('.').map_or("", |(_, extension)| extension);
    if extension.eq_ignore_ascii_case("vcd") || head.trim_ascii_start().starts_with(b"$") {
        return Ok(Format::Vcd);
    }
    by_first_line(head, file, options)
}

/// From the first line that is not blank and does not begin with `#`.
fn by_first_line(head: &[u8], file: &Arc<str>, options: &ReadOptions) -> Result<Format, ReadError> {
    let mut notes = false;
    let mut first = None;
    for (number, line) in (1..).zip(head.split(|&b| b == b'\n')) {
        match line.trim_ascii() {
            [] => {}
            [b'#', ..] => notes = true,
            line => {
                first = Some((number, line));
                break;
            }
        }
    }
    let Some((number, line)) = first else {
        // Header lines and nothing else, which only the native format has.
        return Ok(Format::Native);
    };
    if is_twin(line) {
        return Err(ReadError::UnknownFormat {
            at: Place::line(file, number),
            found: "a twin".to_owned(),
        });
    }
    let names = names(line, delimiter(line));
    let mapped = options.mapped(Signal::Time).map(str::to_lowercase);
    let has = |test: &dyn Fn(&str) -> bool| names.iter().any(|name| test(name));
    if has(&|name| name.eq_ignore_ascii_case("ticks")) {
        return Ok(Format::Native);
    }
    if names.len() == 1
        && (decimal::parse(line, 0) != Err(decimal::DecimalError::Syntax)
            || list::title(line).is_some())
    {
        return Ok(Format::List);
    }
    if has(&is_time) || has(&|name| mapped.as_deref() == Some(&name.to_lowercase())) {
        return Ok(if notes && !has(&is_time) {
            Format::Native
        } else {
            Format::Logic
        });
    }
    if notes {
        return Ok(Format::Native);
    }
    let at = Place::line(file, number);
    if std::str::from_utf8(line).is_err() {
        return Err(ReadError::NotText { at });
    }
    Err(ReadError::UnknownFormat {
        at,
        found: format!("found {}", found(names.iter().map(String::as_str))),
    })
}

/// Whether a line is one of a TOML file: a table, or a bare key with its value.
fn is_twin(line: &[u8]) -> bool {
    let bare = |byte: &u8| byte.is_ascii_alphanumeric() || b"_-.".contains(byte);
    let key = line.split(|byte| *byte == b'=').next().unwrap_or_default();
    let is_key = key.len() < line.len() && key.trim_ascii().iter().all(bare);
    is_key || line.starts_with(b"[") && line.ends_with(b"]")
}

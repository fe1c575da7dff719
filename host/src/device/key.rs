//! The key that device and host share: from a file or the environment, never from a command line, which others can read.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use quadcal::access::{KEY_BYTES, Key};
use thiserror::Error;

/// The environment variable with the key.
pub const KEY_VARIABLE: &str = "QUADCAL_KEY";

/// More than any key file has.
const FILE_BYTES_MAX: u64 = 1024;

/// Why there is no key.
#[derive(Debug, Error)]
pub enum KeyError {
    /// None is given.
    #[error(
        "this changes the device and needs its key; give --key-file PATH, or set {KEY_VARIABLE}"
    )]
    Missing,
    /// The file can't be read.
    #[error("{path}: cannot be read ({source}); check the path and its permissions", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file holds something else.
    #[error(
        "{path}: not a key; it should be {KEY_BYTES} bytes, or {digits} hexadecimal digits",
        path = path.display(),
        digits = 2 * KEY_BYTES
    )]
    File {
        /// The file.
        path: PathBuf,
    },
    /// The variable holds something else.
    #[error("{KEY_VARIABLE}: not a key; it should be {digits} hexadecimal digits", digits = 2 * KEY_BYTES)]
    Variable,
}

/// The key in a file: its bytes as they are, or in hexadecimal digits.
///
/// # Errors
/// [`KeyError::Read`], [`KeyError::File`].
pub fn key_from_file(path: &Path) -> Result<Key, KeyError> {
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(FILE_BYTES_MAX).read_to_end(&mut bytes))
        .map_err(|source| KeyError::Read {
            path: path.to_owned(),
            source,
        })?;
    bytes
        .as_slice()
        .try_into()
        .ok()
        .or_else(|| from_digits(std::str::from_utf8(&bytes).ok()?))
        .ok_or_else(|| KeyError::File {
            path: path.to_owned(),
        })
}

/// The key in [`KEY_VARIABLE`], in hexadecimal digits.
///
/// # Errors
/// [`KeyError::Missing`], [`KeyError::Variable`].
pub fn key_from_environment() -> Result<Key, KeyError> {
    let text = std::env::var_os(KEY_VARIABLE).ok_or(KeyError::Missing)?;
    let digits = text.to_str().and_then(from_digits);
    digits.ok_or(KeyError::Variable)
}

fn from_digits(text: &str) -> Option<Key> {
    let digits = text.trim().as_bytes();
    let mut key = [0; KEY_BYTES];
    if digits.len() != 2 * KEY_BYTES {
        return None;
    }
    for (byte, pair) in key.iter_mut().zip(digits.chunks_exact(2)) {
        let value = |digit: u8| char::from(digit).to_digit(16);
        let [high, low] = [value(pair[0])?, value(pair[1])?];
        *byte = u8::try_from(16 * high + low).ok()?;
    }
    Some(key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_file_holds_bytes_or_digits_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("key");
        let read = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            key_from_file(&path)
        };
        let key: Key = std::array::from_fn(|i| i as u8);
        assert_eq!(read(&key).unwrap(), key);
        let digits = "000102030405060708090a0b0C0D0E0F101112131415161718191a1b1c1d1e1f";
        assert_eq!(read(format!(" {digits}\n").as_bytes()).unwrap(), key);
        for wrong in [
            &digits[1..],
            "",
            &digits.replace('f', "g"),
            &digits.replace("00", "+0"),
        ] {
            let error = read(wrong.as_bytes()).unwrap_err();
            assert!(error.to_string().contains("not a key; "), "{error}");
        }
        assert!(matches!(
            key_from_file(folder.path()),
            Err(KeyError::Read { .. })
        ));
    }
}

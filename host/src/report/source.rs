//! Where a report comes from: program, command line, input files.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use sha2::{Digest, Sha256};

/// Where a report comes from.
#[derive(Clone, Debug, Default)]
pub struct Footer {
    /// Name and version of the program.
    pub version: String,
    /// The command line as typed.
    pub command: String,
    /// What was read.
    pub inputs: Vec<InputFile>,
}

/// An input file, named so that it can be told from every other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// Its path as given.
    pub name: String,
    /// Its size.
    pub bytes: u64,
    /// SHA-256 in hexadecimal.
    pub sha256: String,
}

impl InputFile {
    /// Reads the file once, in pieces, for its size and hash.
    ///
    /// # Errors
    /// Whatever opening or reading it says.
    pub fn read(path: &Path) -> io::Result<Self> {
        let mut file = File::open(path)?;
        let mut hash = Sha256::new();
        let mut piece = vec![0; 1 << 16];
        let mut bytes = 0;
        loop {
            let n = file.read(&mut piece)?;
            if n == 0 {
                break;
            }
            hash.update(&piece[..n]);
            bytes += n as u64;
        }
        Ok(Self {
            name: path.display().to_string(),
            bytes,
            sha256: hash.finalize().iter().map(|b| format!("{b:02x}")).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_file_is_known_by_its_hash() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("abc");
        std::fs::write(&path, "abc").unwrap();
        let file = InputFile::read(&path).unwrap();
        assert_eq!(file.bytes, 3);
        assert!(file.sha256.starts_with("ba7816bf8f01cfea"));
    }
}

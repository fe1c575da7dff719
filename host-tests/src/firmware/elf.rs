//! What is in an image: its size and its symbols.

use std::ops::Range;
use std::path::Path;

use object::read::elf::ProgramHeader;
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, elf};

use super::FirmwareError;

/// Bytes an image takes, as `size` counts them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Code and constants, in flash alone.
    pub text: u64,
    /// Initialised statics: in RAM, their first values in flash.
    pub data: u64,
    /// Statics without first values, in RAM alone.
    pub bss: u64,
}

/// A function or static of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// Demangled, without the hash.
    pub name: String,
    /// Address; bit 0 is set on functions (Thumb).
    pub address: u64,
    /// Size in bytes.
    pub size: u64,
    /// Whether it is code.
    pub code: bool,
}

/// Size of image `path`.
///
/// # Errors
/// The file can't be read or is not an ELF.
pub fn size(path: &Path) -> Result<Size, FirmwareError> {
    with_elf(path, |file| {
        let mut size = Size::default();
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else {
                continue;
            };
            let flag = |bit: elf::SectionFlags| (sh_flags & bit).0 != 0;
            match section.kind() {
                _ if !flag(elf::SHF_ALLOC) => {}
                object::SectionKind::UninitializedData => size.bss += section.size(),
                _ if flag(elf::SHF_WRITE) => size.data += section.size(),
                _ => size.text += section.size(),
            }
        }
        size
    })
}

/// Functions and statics of image `path`, in order of address.
///
/// # Errors
/// The file can't be read or is not an ELF.
pub fn symbols(path: &Path) -> Result<Vec<Symbol>, FirmwareError> {
    with_elf(path, |file| {
        let mut symbols: Vec<Symbol> = file
            .symbols()
            .filter(|symbol| symbol.size() > 0)
            .filter_map(|symbol| {
                Some(Symbol {
                    name: format!("{:#}", rustc_demangle::demangle(symbol.name().ok()?)),
                    address: symbol.address(),
                    size: symbol.size(),
                    code: symbol.kind() == object::SymbolKind::Text,
                })
            })
            .collect();
        symbols.sort_by_key(|symbol| symbol.address);
        symbols
    })
}

/// Addresses that image `path` fills with bytes of its own when it is loaded: the first values of statics count where they are
/// stored.
///
/// # Errors
/// The file can't be read or is not an ELF.
pub fn loaded(path: &Path) -> Result<Vec<Range<u64>>, FirmwareError> {
    with_elf(path, |file| {
        let object::File::Elf32(file) = file else {
            return Vec::new();
        };
        let pieces = file.elf_program_headers().iter();
        pieces
            .filter(|piece| piece.p_type(file.endian()) == elf::PT_LOAD)
            .map(|piece| {
                let start = u64::from(piece.p_paddr(file.endian()));
                start..start + u64::from(piece.p_filesz(file.endian()))
            })
            .filter(|piece| !piece.is_empty())
            .collect()
    })
}

/// Value of a symbol, which the linker script may have set.
///
/// # Errors
/// The file can't be read or is not an ELF.
pub fn value(path: &Path, name: &str) -> Result<Option<u64>, FirmwareError> {
    with_elf(path, |file| {
        file.symbol_by_name(name).map(|symbol| symbol.address())
    })
}

/// Reads an image and hands it to `read`.
pub(super) fn with_elf<T>(
    path: &Path,
    read: impl FnOnce(&object::File<'_>) -> T,
) -> Result<T, FirmwareError> {
    let bytes =
        std::fs::read(path).map_err(FirmwareError::io(format!("reading {}", path.display())))?;
    let file = object::File::parse(bytes.as_slice()).map_err(|source| FirmwareError::Elf {
        path: path.to_owned(),
        source,
    })?;
    Ok(read(&file))
}

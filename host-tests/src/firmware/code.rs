//! What machine code a function of an image can reach: for the promise that the edge path has no panic, no division and
//! no floating point.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::{Path, PathBuf};

use capstone::arch::ArchDetail;
use capstone::arch::arm::{ArchExtraMode, ArchMode, ArmInsn, ArmOperandType, ArmReg};
use capstone::prelude::*;
use object::{Object, ObjectSection, ObjectSymbol};

use super::FirmwareError;
use super::elf::with_elf;

/// One function with all its instructions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Demangled, without the hash.
    pub name: String,
    /// Mnemonics and operands, in order of address.
    pub instructions: Vec<String>,
    /// Whether it calls or jumps through a register, so that what it reaches is not known.
    pub indirect: bool,
}

/// Something that an edge path must not have: the function and what was found in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Offence {
    /// Name of the function.
    pub function: String,
    /// The instruction, or what the name stands for.
    pub what: String,
}

impl Function {
    /// What of this function an edge path must not have.
    fn offences(&self) -> impl Iterator<Item = Offence> {
        let name = self.name.to_lowercase();
        let soft_float = ["__aeabi_f", "__aeabi_d", "__aeabi_cd", "__aeabi_cf"];
        let by_name = [
            (
                "panics",
                name.contains("panic") || name.contains("rust_begin_unwind"),
            ),
            (
                "divides",
                name.contains("div") || name.starts_with("__") && name.contains("mod"),
            ),
            (
                "floating point in software",
                soft_float.iter().any(|start| name.starts_with(start)),
            ),
            ("calls through a register", self.indirect),
        ];
        let named = by_name
            .into_iter()
            .filter(|(_, found)| *found)
            .map(|(what, _)| what.to_owned());
        // Every floating-point instruction of the core begins with v.
        let bad = |text: &&String| {
            text.starts_with("udiv") || text.starts_with("sdiv") || text.starts_with('v')
        };
        let coded = self.instructions.iter().filter(bad).cloned();
        named.chain(coded).map(|what| Offence {
            function: self.name.clone(),
            what,
        })
    }
}

/// What in `functions` an edge path must not have: panics, divisions, floating point, calls that can't be followed.
#[must_use]
pub fn offences(functions: &[Function]) -> Vec<Offence> {
    functions.iter().flat_map(Function::offences).collect()
}

/// The functions whose demangled name is `root`, and all that they can come to by calls and jumps.
///
/// # Errors
/// The file can't be read or is not an ELF, there is no such function, or its code can't be decoded.
pub fn reachable(path: &Path, root: &str) -> Result<Vec<Function>, FirmwareError> {
    with_elf(path, |file| {
        let code = Code::of(path, file)?;
        let mut found: BTreeMap<u64, Function> = BTreeMap::new();
        let mut open = code.named(root);
        if open.is_empty() {
            return Err(code.fault(format!("no function {root}")));
        }
        while let Some(start) = open.pop() {
            if let Entry::Vacant(place) = found.entry(start) {
                let (function, targets) = code.function(start)?;
                place.insert(function);
                open.extend(targets);
            }
        }
        Ok(found.into_values().collect())
    })?
}

/// A function's place.
struct Place {
    name: String,
    end: u64,
}

/// Code of an image, by address; the Thumb bit is taken off all addresses.
struct Code<'a> {
    path: PathBuf,
    places: BTreeMap<u64, Place>,
    /// Where code (true) and data (false) begin, as the linker marked it.
    marks: BTreeMap<u64, bool>,
    sections: Vec<(u64, &'a [u8])>,
    decoder: Capstone,
}

impl<'a> Code<'a> {
    fn of(path: &Path, file: &object::File<'a>) -> Result<Self, FirmwareError> {
        let path = path.to_owned();
        let mut places = BTreeMap::new();
        let mut marks = BTreeMap::new();
        for symbol in file.symbols() {
            let Ok(name) = symbol.name() else { continue };
            let start = symbol.address() & !1;
            if name.starts_with("$t") || name.starts_with("$d") {
                marks.insert(symbol.address(), name.starts_with("$t"));
            } else if symbol.kind() == object::SymbolKind::Text && symbol.size() > 0 {
                let name = format!("{:#}", rustc_demangle::demangle(name));
                let end = start + symbol.size();
                places.insert(start, Place { name, end });
            }
        }
        let sections = file
            .sections()
            .filter(|section| section.kind() == object::SectionKind::Text)
            .filter_map(|section| Some((section.address(), section.data().ok()?)))
            .collect();
        let decoder = Capstone::new()
            .arm()
            .mode(ArchMode::Thumb)
            .extra_mode(std::iter::once(ArchExtraMode::MClass))
            .detail(true)
            .build();
        let decoder = decoder.map_err(|error| FirmwareError::Code {
            path: path.clone(),
            reason: error.to_string(),
        })?;
        Ok(Self {
            path,
            places,
            marks,
            sections,
            decoder,
        })
    }

    fn named(&self, name: &str) -> Vec<u64> {
        let named = self.places.iter().filter(|(_, place)| place.name == name);
        named.map(|(start, _)| *start).collect()
    }

    /// Decodes the function at `start`; also gives the starts of those it calls or jumps into.
    fn function(&self, start: u64) -> Result<(Function, Vec<u64>), FirmwareError> {
        let place = self
            .places
            .get(&start)
            .ok_or_else(|| self.fault(format!("no function at {start:#x}")))?;
        let mut function = Function {
            name: place.name.clone(),
            instructions: Vec::new(),
            indirect: false,
        };
        let mut targets = Vec::new();
        for (from, to) in self.stretches(start, place.end) {
            let bytes = self
                .bytes(from, to)
                .ok_or_else(|| self.fault(format!("no code at {from:#x}")))?;
            let decoded = self
                .decoder
                .disasm_all(bytes, from)
                .map_err(|error| self.fault(format!("{from:#x}: {error}")))?;
            let length: usize = decoded.iter().map(|insn| insn.bytes().len()).sum();
            if length != bytes.len() {
                let at = from + length as u64;
                return Err(self.fault(format!("{at:#x} in {} can't be decoded", place.name)));
            }
            for instruction in decoded.iter() {
                match self.goes_to(instruction)? {
                    Some(Way::To(target)) if !(start..place.end).contains(&target) => {
                        targets.push(self.enclosing(target)?);
                    }
                    Some(Way::Unknown) => function.indirect = true,
                    _ => {}
                }
                let text = |part: Option<&str>| part.unwrap_or_default().to_owned();
                let line = text(instruction.mnemonic()) + " " + &text(instruction.op_str());
                function.instructions.push(line);
            }
        }
        Ok((function, targets))
    }

    /// The parts of a function that are code, not constants or jump tables.
    fn stretches(&self, start: u64, end: u64) -> Vec<(u64, u64)> {
        let mut code = self
            .marks
            .range(..=start)
            .next_back()
            .is_none_or(|(_, code)| *code);
        let mut from = start;
        let mut stretches = Vec::new();
        let inside = self
            .marks
            .range(start + 1..end)
            .map(|(at, code)| (*at, *code));
        for (at, is_code) in inside.chain([(end, false)]) {
            if code && at > from {
                stretches.push((from, at));
            }
            (code, from) = (is_code, at);
        }
        stretches
    }

    fn bytes(&self, from: u64, to: u64) -> Option<&'a [u8]> {
        self.sections.iter().find_map(|(address, data)| {
            let range = from.checked_sub(*address)? as usize..to.checked_sub(*address)? as usize;
            data.get(range)
        })
    }

    /// Where an instruction goes besides the next one; none if nowhere, or back to the caller.
    fn goes_to(&self, instruction: &capstone::Insn<'_>) -> Result<Option<Way>, FirmwareError> {
        let detail = self
            .decoder
            .insn_detail(instruction)
            .map_err(|error| self.fault(error.to_string()))?;
        let ArchDetail::ArmDetail(arm) = detail.arch_detail();
        let lr = RegId(ArmReg::ARM_REG_LR as u16);
        let pc = RegId(ArmReg::ARM_REG_PC as u16);
        let sp = RegId(ArmReg::ARM_REG_SP as u16);
        let operands: Vec<ArmOperandType> = arm.operands().map(|operand| operand.op_type).collect();
        let register = |reg: RegId| if reg == lr { None } else { Some(Way::Unknown) };
        let id = instruction.id().0;
        let is = |insns: &[ArmInsn]| insns.iter().any(|insn| *insn as u32 == id);
        use ArmInsn::{
            ARM_INS_B, ARM_INS_BL, ARM_INS_BLX, ARM_INS_BX, ARM_INS_CBNZ, ARM_INS_CBZ, ARM_INS_POP,
            ARM_INS_TBB, ARM_INS_TBH,
        };
        if is(&[
            ARM_INS_B,
            ARM_INS_BL,
            ARM_INS_BLX,
            ARM_INS_BX,
            ARM_INS_CBZ,
            ARM_INS_CBNZ,
        ]) {
            return Ok(match operands.last() {
                Some(ArmOperandType::Imm(target)) => Some(Way::To(u64::from(*target as u32) & !1)),
                Some(ArmOperandType::Reg(reg)) => register(*reg),
                _ => Some(Way::Unknown),
            });
        }
        // Table branches stay in their function; a pop returns.
        if is(&[ARM_INS_TBB, ARM_INS_TBH, ARM_INS_POP]) {
            return Ok(None);
        }
        let from_stack = operands
            .iter()
            .any(|operand| matches!(operand, ArmOperandType::Mem(memory) if memory.base() == sp));
        let writes_pc = matches!(operands.first(), Some(ArmOperandType::Reg(reg)) if *reg == pc);
        Ok((writes_pc && !from_stack).then_some(Way::Unknown))
    }

    /// Start of the function that holds `address`.
    fn enclosing(&self, address: u64) -> Result<u64, FirmwareError> {
        let before = self.places.range(..=address).next_back();
        before
            .filter(|(_, place)| address < place.end)
            .map(|(start, _)| *start)
            .ok_or_else(|| self.fault(format!("no function at {address:#x}")))
    }

    fn fault(&self, reason: String) -> FirmwareError {
        FirmwareError::Code {
            path: self.path.clone(),
            reason,
        }
    }
}

/// Where an instruction goes.
enum Way {
    To(u64),
    Unknown,
}

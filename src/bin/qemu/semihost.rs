//! Files, command line and exit code of the host, through ARM semihosting.

use core::fmt;

use cortex_m_semihosting::{debug, nr, syscall, syscall1};

/// Longest path that can be opened, in bytes.
const PATH_LEN: usize = 127;

/// A semihosting call that the host refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IoError {
    /// No command line, or one too long for the buffer, or not UTF-8.
    CommandLine,
    /// The path is longer than the buffer for it.
    PathTooLong,
    /// The file can't be opened.
    Open,
    /// Reading failed.
    Read,
    /// Not every byte was written.
    Write,
    /// There is no such place in the file, or it has no length.
    Seek,
    /// The file can't be closed: its bytes may not be there.
    Close,
}

impl fmt::Display for IoError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::CommandLine => "the host gave no usable command line",
            Self::PathTooLong => "a path is longer than 127 bytes",
            Self::Open => "can't open a file",
            Self::Read => "can't read a file",
            Self::Write => "can't write a file",
            Self::Seek => "can't find a place in a file",
            Self::Close => "can't close a file",
        })
    }
}

/// What to open a file for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Read an existing file.
    Read,
    /// Write a new file, or one cut to nothing.
    Write,
    /// Read and write an existing file.
    Update,
}

/// An open file of the host. Unbuffered: every call stops the target, so hand over kilobytes at a time.
pub struct File {
    handle: usize,
}

impl File {
    /// Opens `path`, relative to the directory QEMU was started in.
    pub fn open(path: &str, mode: Mode) -> Result<Self, IoError> {
        let mut name = [0_u8; PATH_LEN + 1];
        name.get_mut(..path.len().min(PATH_LEN + 1))
            .filter(|name| name.len() == path.len() && name.len() <= PATH_LEN)
            .ok_or(IoError::PathTooLong)?
            .copy_from_slice(path.as_bytes());
        let mode = match mode {
            Mode::Read => nr::open::R_BINARY,
            Mode::Write => nr::open::W_TRUNC_BINARY,
            Mode::Update => nr::open::RW_BINARY,
        };
        // SAFETY: OPEN takes the address of a NUL-terminated path, a mode and the path's length, and only reads; `name` is
        // longer than the path by at least one zero and outlives the call.
        match unsafe { syscall!(OPEN, name.as_ptr(), mode, path.len()) } {
            usize::MAX => Err(IoError::Open),
            handle => Ok(Self { handle }),
        }
    }

    /// Fills `buffer` from the file and says how many bytes came; fewer than asked for only at the file's end.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<usize, IoError> {
        let mut done = 0;
        while done < buffer.len() {
            let rest = &mut buffer[done..];
            // SAFETY: READ writes at most the given length to the given address; both are those of `rest`, which is borrowed
            // for the call alone.
            let missing = unsafe { syscall!(READ, self.handle, rest.as_mut_ptr(), rest.len()) };
            match rest.len().checked_sub(missing) {
                None => return Err(IoError::Read),
                Some(0) => break,
                Some(got) => done += got,
            }
        }
        Ok(done)
    }

    /// Reads what there is up to the buffer's length and says how many bytes came; none at the file's end, where more may come later.
    pub fn read_some(&mut self, buffer: &mut [u8]) -> Result<usize, IoError> {
        // SAFETY: as in `read`, with all of the buffer.
        let missing = unsafe { syscall!(READ, self.handle, buffer.as_mut_ptr(), buffer.len()) };
        buffer.len().checked_sub(missing).ok_or(IoError::Read)
    }

    /// Reads `length` bytes to memory at `address`, which may be flash: QEMU writes there as a debugger does.
    ///
    /// # Safety
    /// Nothing that Rust knows of may change by it.
    pub unsafe fn read_to(&mut self, address: usize, length: usize) -> Result<(), IoError> {
        // SAFETY: READ writes at most `length` bytes to `address`; the caller answers for them.
        match unsafe { syscall!(READ, self.handle, address, length) } {
            0 => Ok(()),
            _ => Err(IoError::Read),
        }
    }

    /// Writes all of `bytes`.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), IoError> {
        // SAFETY: WRITE reads the given length from the given address; both are those of `bytes`.
        match unsafe { syscall!(WRITE, self.handle, bytes.as_ptr(), bytes.len()) } {
            0 => Ok(()),
            _ => Err(IoError::Write),
        }
    }

    /// Goes to a place, in bytes from the file's start.
    pub fn seek(&mut self, position: usize) -> Result<(), IoError> {
        // SAFETY: SEEK takes two numbers and no memory.
        match unsafe { syscall!(SEEK, self.handle, position) } {
            0 => Ok(()),
            _ => Err(IoError::Seek),
        }
    }

    /// Bytes of the file.
    pub fn length(&self) -> Result<usize, IoError> {
        // SAFETY: FLEN takes a handle and no memory.
        match unsafe { syscall!(FLEN, self.handle) } {
            usize::MAX => Err(IoError::Seek),
            length => Ok(length),
        }
    }

    /// Closes the file, so that its bytes are in the host's hands. A file that is dropped instead is closed by the host at
    /// exit.
    pub fn close(self) -> Result<(), IoError> {
        // SAFETY: CLOSE takes a handle that OPEN gave; `self` is gone afterwards, so nothing uses it again.
        match unsafe { syscall!(CLOSE, self.handle) } {
            0 => Ok(()),
            _ => Err(IoError::Close),
        }
    }
}

/// The words of QEMU's `-semihosting-config arg=...` options, with blanks between.
pub fn command_line(buffer: &mut [u8]) -> Result<&str, IoError> {
    let mut answer = [buffer.as_mut_ptr() as usize, buffer.len()];
    // SAFETY: GET_CMDLINE writes at most the given length to the given address, both those of `buffer`, and then the line's
    // length into the block. Both addresses come from mutable borrows.
    let status = unsafe { syscall1(nr::GET_CMDLINE, answer.as_mut_ptr() as usize) };
    let [_, length] = answer;
    if status != 0 {
        return Err(IoError::CommandLine);
    }
    let line = buffer.get(..length).ok_or(IoError::CommandLine)?;
    let line = line.split(|&byte| byte == 0).next().unwrap_or(line);
    core::str::from_utf8(line).map_err(|_| IoError::CommandLine)
}

/// Time since QEMU was started, nanoseconds: by the host's clock, so that it goes on while a call stops the target.
pub fn elapsed_ns() -> u64 {
    let mut ticks = [0_u32; 2];
    // SAFETY: ELAPSED writes two words to the given address, those of `ticks`.
    unsafe { syscall1(nr::ELAPSED, ticks.as_mut_ptr() as usize) };
    let [low, high] = ticks;
    u64::from(high) << 32 | u64::from(low)
}

/// Ends the run with exit code 0 or 1.
pub fn exit(success: bool) -> ! {
    loop {
        debug::exit(if success {
            debug::EXIT_SUCCESS
        } else {
            debug::EXIT_FAILURE
        });
    }
}

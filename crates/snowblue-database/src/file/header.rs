//! Validates the header of a NetCDF classic file before anything is read according to it.
//!
//! The header (NetCDF Classic Format Specification, Unidata) lists dimensions, attributes and variables with their
//! lengths. A damaged length could request any amount of memory, so every length is compared with the bytes that exist.

/// Most bytes of a header: enough for the axes, attributes and variables of any table.
pub(super) const MAX_BYTES: u64 = 1 << 24;

const DIMENSION: u32 = 0x0a;
const VARIABLE: u32 = 0x0b;
const ATTRIBUTE: u32 = 0x0c;

/// The unread part of a header.
struct Unread<'b>(&'b [u8]);

/// Checks the header at the start of a file of `length` bytes.
///
/// # Errors
/// What is invalid, in a few words.
pub(super) fn check(start: &[u8], length: u64) -> Result<(), &'static str> {
    let mut rest = Unread(start);
    let has_wide_offsets = match rest.take(4)? {
        b"CDF\x01" => false,
        b"CDF\x02" => true,
        _ => return Err("it does not start as one"),
    };
    rest.number()?;
    let mut dimensions = Vec::new();
    for _ in 0..rest.list(DIMENSION)? {
        rest.name()?;
        match rest.number()? {
            0 => return Err("it has an unlimited or empty dimension, which a table does not have"),
            size => dimensions.push(u64::from(size)),
        }
    }
    rest.attributes()?;
    for _ in 0..rest.list(VARIABLE)? {
        rest.name()?;
        let mut values = 1_u64;
        for _ in 0..rest.number()? {
            let size = usize::try_from(rest.number()?).ok().and_then(|dimension| dimensions.get(dimension));
            let size = size.ok_or("a variable has an unknown dimension")?;
            values = values.checked_mul(*size).ok_or("a variable is too large")?;
        }
        rest.attributes()?;
        let bytes = values.checked_mul(rest.size_of_type()?).ok_or("a variable is too large")?;
        rest.number()?;
        let high = if has_wide_offsets { u64::from(rest.number()?) << 32 } else { 0 };
        let begin = high | u64::from(rest.number()?);
        if begin.checked_add(bytes).is_none_or(|end| end > length) {
            return Err("it ends before its last value");
        }
    }
    Ok(())
}

impl<'b> Unread<'b> {
    fn take(&mut self, count: usize) -> Result<&'b [u8], &'static str> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or("its header is truncated")?;
        self.0 = rest;
        Ok(taken)
    }

    fn number(&mut self) -> Result<u32, &'static str> {
        let bytes = self.take(4)?;
        Ok(bytes.iter().fold(0, |number, byte| number << 8 | u32::from(*byte)))
    }

    /// The length of a list of the given kind.
    fn list(&mut self, kind: u32) -> Result<u32, &'static str> {
        match (self.number()?, self.number()?) {
            (0, 0) => Ok(0),
            (found, count) if found == kind => Ok(count),
            _ => Err("its header is invalid"),
        }
    }

    /// Skips bytes, which are padded to a multiple of four.
    fn skip(&mut self, bytes: u64) -> Result<(), &'static str> {
        let padded = usize::try_from(bytes).ok().and_then(|bytes| bytes.checked_next_multiple_of(4));
        self.take(padded.ok_or("its header is invalid")?).map(|_| ())
    }

    fn name(&mut self) -> Result<(), &'static str> {
        let length = self.number()?;
        self.skip(u64::from(length))
    }

    fn attributes(&mut self) -> Result<(), &'static str> {
        for _ in 0..self.list(ATTRIBUTE)? {
            self.name()?;
            let size = self.size_of_type()?;
            let count = self.number()?;
            self.skip(size * u64::from(count))?;
        }
        Ok(())
    }

    /// Bytes of a value of the type that follows.
    fn size_of_type(&mut self) -> Result<u64, &'static str> {
        match self.number()? {
            1 | 2 => Ok(1),
            3 => Ok(2),
            4 | 5 => Ok(4),
            6 => Ok(8),
            _ => Err("its header is invalid"),
        }
    }
}

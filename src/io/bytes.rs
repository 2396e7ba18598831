//! Little-endian numbers in the bytes of a file, for all readers that take them by hand. What it
//! means that bytes are missing the reader says itself.

/// A number that stands in files as bytes, the least significant first.
pub(crate) trait Number: Sized {
    /// As many bytes as it takes.
    type Bytes: Default + AsMut<[u8]> + for<'a> TryFrom<&'a [u8]>;

    /// Makes the number of its bytes.
    fn of(bytes: Self::Bytes) -> Self;
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Number for $number {
            type Bytes = [u8; size_of::<$number>()];

            fn of(bytes: Self::Bytes) -> Self {
                Self::from_le_bytes(bytes)
            }
        }
    )*};
}

numbers!(i8, u8, i16, u16, i32, u32, u64, f32, f64);

/// Takes from bytes one thing after the other; nothing where so much is not left.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cursor<'a>(pub(crate) &'a [u8]);

impl<'a> Cursor<'a> {
    /// Takes so many bytes.
    pub(crate) fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    /// Takes a number.
    pub(crate) fn number<T: Number>(&mut self) -> Option<T> {
        let bytes = T::Bytes::try_from(self.take(size_of::<T>())?);
        bytes.ok().map(T::of)
    }
}

/// Reads the number at `at`, if it is there.
pub(crate) fn number_at<T: Number>(bytes: &[u8], at: usize) -> Option<T> {
    Cursor(bytes.get(at..)?).number()
}

/// Reads the number at `at`; the caller has made sure that it is there.
pub(crate) fn field<T: Number>(bytes: &[u8], at: usize) -> T {
    let mut field = T::Bytes::default();
    field.as_mut().copy_from_slice(&bytes[at..at + size_of::<T>()]);
    T::of(field)
}

/// Writes a number, 7 bits a byte, the last ones first, the highest bit set on all bytes but the
/// last.
pub(crate) fn push_number(bytes: &mut Vec<u8>, mut number: u64) {
    while number > 0x7f {
        bytes.push((number & 0x7f) as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

/// Maps 0, -1, 1, -2, ... to 0, 1, 2, 3, ...
pub(crate) const fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

/// Takes [`zigzag`] back.
pub(crate) const fn unzigzag(number: u64) -> i64 {
    (number >> 1) as i64 ^ -((number & 1) as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_taken_until_bytes_end() {
        let mut cursor = Cursor(&[0xff, 1, 2, 0, 0, 0x80, 0x3f, 7]);
        assert_eq!(cursor.number::<i8>(), Some(-1));
        assert_eq!(cursor.number::<u16>(), Some(0x0201));
        assert_eq!(cursor.number::<f32>(), Some(1.0));
        assert_eq!((cursor.number::<u32>(), cursor.take(2)), (None, None));
        assert_eq!((cursor.take(1), cursor.number::<u8>()), (Some(&[7][..]), None));
        assert_eq!(number_at::<u16>(&[0, 1, 2], 1), Some(0x0201));
        assert_eq!((number_at::<u16>(&[0, 1, 2], 2), number_at::<u8>(&[], 3)), (None, None));
        assert_eq!(field::<u16>(&[0, 1, 2], 1), 0x0201);
    }
}

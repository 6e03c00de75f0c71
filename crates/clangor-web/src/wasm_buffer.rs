//! Memory shared by the page and the module: bytes in, text out.

use std::cell::RefCell;

/// Largest buffer \[bytes\].
const LARGEST: u32 = 1 << 28;

thread_local! {
    // Words of 8 bytes, because the content may be f64.
    static BUFFER: RefCell<Vec<u64>> = const { RefCell::new(Vec::new()) };
    static MESSAGE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Returns a buffer of this length \[bytes\], aligned to 8, valid until the next call; null beyond 256 MiB.
pub fn buffer(bytes: u32) -> *const u64 {
    if bytes > LARGEST {
        return std::ptr::null();
    }
    BUFFER.with_borrow_mut(|buffer| {
        let words = bytes.div_ceil(8) as usize;
        if buffer.len() < words {
            buffer.resize(words, 0);
        }
        buffer.as_ptr()
    })
}

/// The last error message or report, UTF-8.
pub fn message() -> *const u8 {
    MESSAGE.with_borrow(|text| text.as_ptr())
}

/// Length of [`message`] \[bytes\].
pub fn message_length() -> u32 {
    MESSAGE.with_borrow(|text| text.len() as u32)
}

/// The text of [`message`].
pub fn last_message() -> String {
    MESSAGE.with_borrow(String::clone)
}

/// Sets the text of [`message`].
pub fn tell(text: String) {
    MESSAGE.replace(text);
}

/// Status code of a result; an error sets [`message`].
pub fn status<E: std::fmt::Display>(outcome: Result<i32, E>) -> i32 {
    outcome.unwrap_or_else(|error| {
        tell(error.to_string());
        -1
    })
}

/// Puts bytes into the buffer, as a page does. Returns their number.
pub fn write(bytes: &[u8]) -> u32 {
    buffer(bytes.len() as u32);
    BUFFER.with_borrow_mut(|buffer| {
        for (word, chunk) in buffer.iter_mut().zip(bytes.chunks(8)) {
            let mut eight = [0; 8];
            eight[..chunk.len()].copy_from_slice(chunk);
            *word = u64::from_le_bytes(eight);
        }
    });
    bytes.len() as u32
}

/// The first bytes of the buffer, at most its length.
pub fn bytes(count: u32) -> Vec<u8> {
    BUFFER.with_borrow(|buffer| {
        let words = &buffer[..buffer.len().min(count.div_ceil(8) as usize)];
        let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        bytes.truncate(count as usize);
        bytes
    })
}

/// Calls `read` with the words of the buffer, which are numbers by [`f64::from_bits`].
pub fn with_words<T>(read: impl FnOnce(&[u64]) -> T) -> T {
    BUFFER.with_borrow(|buffer| read(buffer))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let text = "half-space".as_bytes();
        assert_eq!(bytes(write(text)), text);
        assert_eq!(bytes(2), b"ha");
        assert!(buffer(u32::MAX).is_null());
        assert_eq!(status(Err::<i32, _>("because")), -1);
        assert_eq!(last_message(), "because");
    }
}

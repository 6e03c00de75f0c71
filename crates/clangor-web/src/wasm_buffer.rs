//! What the page and the module hand each other besides numbers: bytes in, text out.

use std::cell::RefCell;

/// Largest buffer \[bytes\].
const LARGEST: u32 = 1 << 28;

thread_local! {
    // Words, because what lies there may be numbers.
    static BUFFER: RefCell<Vec<u64>> = const { RefCell::new(Vec::new()) };
    static MESSAGE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Room for so many bytes, aligned to 8, valid until the next call; null beyond 256 MiB.
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

/// The last refusal or report, UTF-8.
pub fn message() -> *const u8 {
    MESSAGE.with_borrow(|text| text.as_ptr())
}

/// Its length \[bytes\].
pub fn message_length() -> u32 {
    MESSAGE.with_borrow(|text| text.len() as u32)
}

/// What [`message`] tells.
pub fn last_message() -> String {
    MESSAGE.with_borrow(String::clone)
}

/// Sets what [`message`] tells.
pub fn tell(text: String) {
    MESSAGE.replace(text);
}

/// The status of an outcome; a refusal is told.
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

/// The first bytes of the buffer; as many as there are, if fewer.
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

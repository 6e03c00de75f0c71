//! Random changes of an input: of bits, bytes, numbers, words, lines and pieces.

/// Numbers at which code that reads them fails.
const NUMBERS: [&str; 30] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "3",
    "1e-9",
    "0.5",
    "-0.5",
    "1e9",
    "1e18",
    "1e38",
    "1e39",
    "1e308",
    "-1e308",
    "1e309",
    "5e-324",
    "1e-308",
    "nan",
    "inf",
    "-inf",
    "NaN",
    "null",
    "255",
    "256",
    "65536",
    "2147483648",
    "4294967295",
    "18446744073709551615",
    "99999999999999999999",
];

/// Words of binary formats.
const WORDS: [u64; 10] =
    [0, 1, 0x7f, 0xff, 0xffff, 0x7fff_ffff, 0xffff_ffff, i64::MAX as u64, u64::MAX, 0x7ff0_0000_0000_0000];

/// xorshift64: seeded, so that every run sees the same numbers.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64, name: &str) -> Self {
        let mix = |sum: u64, byte: u8| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        let start = name.bytes().fold(0xcbf2_9ce4_8422_2325 ^ seed.wrapping_mul(0x9e37_79b9_7f4a_7c15), mix);
        Random(start | 1)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// Below `end`; 0 for an empty range.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        if end == 0 { 0 } else { ((self.next() >> 16) % end as u64) as usize }
    }

    pub(crate) fn pick<'a, T: ?Sized>(&mut self, from: &[&'a T]) -> Option<&'a T> {
        from.get(self.below(from.len())).copied()
    }

    /// A range of at most `longest` within `length`.
    fn range(&mut self, length: usize, longest: usize) -> std::ops::Range<usize> {
        let start = self.below(length + 1);
        let count = self.below(longest.min(length - start) + 1);
        start..start + count
    }

    /// One of the inputs after a few changes.
    pub(crate) fn changed(&mut self, inputs: &[Vec<u8>], words: &[&str]) -> Vec<u8> {
        let Some(input) = inputs.get(self.below(inputs.len())) else { return Vec::new() };
        let mut input = input.clone();
        for _ in 0..=self.below(4) {
            self.change(&mut input, inputs, words);
        }
        input
    }

    fn change(&mut self, input: &mut Vec<u8>, inputs: &[Vec<u8>], words: &[&str]) {
        let length = input.len();
        match self.below(13) {
            0 if length > 0 => input[self.below(length)] ^= 1 << self.below(8),
            1 if length > 0 => input[self.below(length)] = self.next() as u8,
            2 => drop(input.drain(self.range(length, 64))),
            3 => {
                // A piece once more, elsewhere or there, up to many times.
                let piece = input[self.range(length, 256)].to_vec();
                let times = if self.below(50) == 0 { 1 + self.below(2000) } else { 1 };
                let at = self.below(length + 1);
                input.splice(at..at, piece.repeat(times));
            }
            4..=6 => self.change_number(input),
            7 | 8 => {
                let word = self.pick(words).unwrap_or_default().as_bytes().to_vec();
                let cut = self.below(12);
                let at = self.range(length, cut);
                input.splice(at, word);
            }
            9 => {
                // The end of another input.
                let other = &inputs[self.below(inputs.len())];
                let (keep, from) = (self.below(length + 1), self.below(other.len() + 1));
                input.truncate(keep);
                input.extend_from_slice(&other[from..]);
            }
            10 => {
                let word = WORDS[self.below(WORDS.len())].to_le_bytes();
                let width = [1, 2, 4, 8][self.below(4)];
                if length >= width {
                    let at = self.below(length - width + 1);
                    input[at..at + width].copy_from_slice(&word[..width]);
                }
            }
            11 => self.swap_lines(input),
            _ => {
                // A number of binary data, with a double that few expect.
                let double = [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e300, 1e-300][self.below(6)];
                if length >= 8 {
                    let at = self.below(length / 8) * 8;
                    input[at..at + 8].copy_from_slice(&double.to_le_bytes());
                }
            }
        }
    }

    /// Puts another number in the place of one that is written in digits.
    fn change_number(&mut self, input: &mut Vec<u8>) {
        let from = self.below(input.len() + 1);
        let Some(start) = input[from..].iter().position(u8::is_ascii_digit) else { return };
        let start = from + start;
        let part = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'e' | b'E' | b'-' | b'+');
        let end = start + input[start..].iter().take_while(|byte| part(byte)).count();
        let number = match self.below(3) {
            0 => self.below(100).to_string(),
            1 => format!("{:e}", f64::from_bits(self.next())),
            _ => NUMBERS[self.below(NUMBERS.len())].into(),
        };
        input.splice(start..end, number.into_bytes());
    }

    fn swap_lines(&mut self, input: &mut Vec<u8>) {
        let mut lines: Vec<Vec<u8>> = input.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
        let (one, two) = (self.below(lines.len()), self.below(lines.len()));
        if self.below(2) == 0 {
            lines.swap(one, two);
        } else {
            let copy = lines[one].clone();
            lines.insert(two, copy);
        }
        *input = lines.join(&b'\n');
    }
}

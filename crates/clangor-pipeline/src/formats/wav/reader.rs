//! The reading half: finds the samples behind any order of chunks and hands them out a block at a time.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::writer::{SUBFORMAT_TAIL, TAG_EXTENSIBLE, TAG_FLOAT, TAG_PCM};
use super::{WavError, full_scale_in};

/// How a file stores its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WavEncoding {
    /// Signed integers of 16 bits.
    Pcm16,
    /// Signed integers of 24 bits.
    Pcm24,
    /// Signed integers of 32 bits.
    Pcm32,
    /// IEEE floats of 32 bits.
    Float32,
    /// IEEE floats of 64 bits.
    Float64,
}

impl WavEncoding {
    /// Bytes of a sample.
    pub fn bytes(self) -> usize {
        match self {
            WavEncoding::Pcm16 => 2,
            WavEncoding::Pcm24 => 3,
            WavEncoding::Pcm32 | WavEncoding::Float32 => 4,
            WavEncoding::Float64 => 8,
        }
    }
}

/// What the header of a WAV file says.
#[derive(Clone, Debug, PartialEq)]
pub struct WavInfo {
    /// Sample rate \[Hz\].
    pub sample_rate: u32,
    /// Channels.
    pub channels: u16,
    /// How samples are stored.
    pub encoding: WavEncoding,
    /// Frames (samples of each channel).
    pub frames: u64,
    /// The comment, if any.
    pub comment: Option<String>,
    /// Pressure of a sample of 1.0 \[Pa\], if the comment says so.
    pub full_scale: Option<f64>,
}

impl WavInfo {
    /// Length \[s\].
    pub fn duration(&self) -> f64 {
        self.frames as f64 / f64::from(self.sample_rate)
    }
}

/// Reads one WAV file from its first sample to its last.
#[derive(Debug)]
pub struct WavReader {
    file: BufReader<File>,
    path: PathBuf,
    info: WavInfo,
    next_frame: u64,
    bytes: Vec<u8>,
}

impl WavReader {
    /// Reads the header.
    ///
    /// # Errors
    /// [`WavError`] names the file and the place where it stops being a WAV file.
    pub fn open(path: &Path) -> Result<Self, WavError> {
        let io_error = |source| WavError::Io { action: "read", path: path.into(), source };
        let file = File::open(path).map_err(io_error)?;
        let length = file.metadata().map_err(io_error)?.len();
        let mut file = BufReader::new(file);
        let (info, data_at) = Header { file: &mut file, path, length, at: 0 }.parse()?;
        file.seek(SeekFrom::Start(data_at)).map_err(io_error)?;
        Ok(WavReader { file, path: path.into(), info, next_frame: 0, bytes: Vec::new() })
    }

    /// The header.
    pub fn info(&self) -> &WavInfo {
        &self.info
    }

    /// Appends up to `max_frames` frames, interleaved, full scale ±1, and returns how many; 0 at the end.
    ///
    /// # Errors
    /// [`WavError`], among others for a sample that is not finite.
    pub fn read(&mut self, samples: &mut Vec<f32>, max_frames: usize) -> Result<usize, WavError> {
        let left = self.info.frames - self.next_frame;
        let frames = usize::try_from(left).map_or(max_frames, |left| left.min(max_frames));
        let channels = usize::from(self.info.channels);
        let width = self.info.encoding.bytes();
        self.bytes.resize(frames * channels * width, 0);
        self.file.read_exact(&mut self.bytes).map_err(|source| WavError::Io {
            action: "read",
            path: self.path.clone(),
            source,
        })?;
        samples.reserve(frames * channels);
        for (i, bytes) in self.bytes.chunks_exact(width).enumerate() {
            let sample = decode(self.info.encoding, bytes);
            if !sample.is_finite() {
                let frame = self.next_frame + (i / channels) as u64;
                return Err(WavError::NotFinite { frame, channel: i % channels });
            }
            samples.push(sample);
        }
        self.next_frame += frames as u64;
        Ok(frames)
    }
}

fn decode(encoding: WavEncoding, bytes: &[u8]) -> f32 {
    let mut word = [0; 8];
    // Integers are aligned to the top of 32 bits, so that one scale serves all.
    let top = if bytes.len() < 4 { 4 - bytes.len() } else { 0 };
    word[top..top + bytes.len()].copy_from_slice(bytes);
    let [a, b, c, d, ..] = word;
    match encoding {
        WavEncoding::Float32 => f32::from_le_bytes([a, b, c, d]),
        WavEncoding::Float64 => f64::from_le_bytes(word) as f32,
        _ => (f64::from(i32::from_le_bytes([a, b, c, d])) / f64::from(1_u32 << 31)) as f32,
    }
}

/// Walks the chunks of a file.
struct Header<'a> {
    file: &'a mut BufReader<File>,
    path: &'a Path,
    length: u64,
    at: u64,
}

impl Header<'_> {
    /// The header's content and where the samples start.
    fn parse(mut self) -> Result<(WavInfo, u64), WavError> {
        let magic: [u8; 12] = self.take()?;
        let wide = match &magic[..4] {
            b"RIFF" => false,
            b"RF64" | b"BW64" => true,
            _ => return Err(self.malformed(0, "it does not begin with RIFF or RF64")),
        };
        if &magic[8..] != b"WAVE" {
            return Err(self.malformed(8, "the form is not WAVE"));
        }
        let (mut format, mut data, mut comment, mut wide_data) = (None, None, None, None);
        while self.at + 8 <= self.length {
            let chunk_at = self.at;
            let head: [u8; 8] = self.take()?;
            let [a, b, c, d, size @ ..] = head;
            let mut size = u64::from(u32::from_le_bytes(size));
            let start = self.at;
            match &[a, b, c, d] {
                b"ds64" if size >= 28 => {
                    let sizes: [u8; 24] = self.take()?;
                    let [_, _, _, _, _, _, _, _, wide_size @ ..] = sizes;
                    wide_data = wide_size.first_chunk().map(|s| u64::from_le_bytes(*s));
                }
                b"fmt " => format = Some(self.parse_format(size)?),
                b"LIST" => comment = self.parse_info(size)?.or(comment),
                b"data" => {
                    if wide && size == 0xFFFF_FFFF {
                        size =
                            wide_data.ok_or_else(|| self.malformed(chunk_at, "RF64 lacks its ds64 chunk"))?;
                    }
                    let present = self.length - start;
                    if size > present {
                        return Err(WavError::Truncated { path: self.path.into(), promised: size, present });
                    }
                    data = Some((start, size));
                }
                _ => {}
            }
            let next = size.checked_add(size % 2).and_then(|s| start.checked_add(s));
            self.go_to(next.unwrap_or(self.length).min(self.length))?;
        }
        let (channels, sample_rate, encoding) =
            format.ok_or_else(|| self.malformed(12, "there is no fmt chunk"))?;
        let (data_at, size) = data.ok_or_else(|| self.malformed(self.length, "there is no data chunk"))?;
        let block = u64::from(channels) * encoding.bytes() as u64;
        if size % block != 0 {
            return Err(self.malformed(data_at, "the data chunk does not hold whole frames"));
        }
        let full_scale = comment.as_deref().and_then(full_scale_in);
        Ok((WavInfo { sample_rate, channels, encoding, frames: size / block, comment, full_scale }, data_at))
    }

    fn parse_format(&mut self, size: u64) -> Result<(u16, u32, WavEncoding), WavError> {
        let at = self.at;
        if size < 16 {
            return Err(self.malformed(at, "the fmt chunk is too short"));
        }
        let fmt: [u8; 16] = self.take()?;
        let word = |i: usize| u16::from_le_bytes([fmt[i], fmt[i + 1]]);
        let (mut tag, channels, block, bits) = (word(0), word(2), word(12), word(14));
        let rate = u32::from_le_bytes([fmt[4], fmt[5], fmt[6], fmt[7]]);
        if tag == TAG_EXTENSIBLE {
            if size < 40 {
                return Err(self.malformed(at, "the extensible fmt chunk is too short"));
            }
            let extension: [u8; 24] = self.take()?;
            tag = u16::from_le_bytes([extension[8], extension[9]]);
            if extension[10..] != SUBFORMAT_TAIL {
                return Err(self.malformed(at + 24, "the sub-format is unknown"));
            }
        }
        let encoding = match (tag, bits) {
            (TAG_PCM, 16) => WavEncoding::Pcm16,
            (TAG_PCM, 24) => WavEncoding::Pcm24,
            (TAG_PCM, 32) => WavEncoding::Pcm32,
            (TAG_FLOAT, 32) => WavEncoding::Float32,
            (TAG_FLOAT, 64) => WavEncoding::Float64,
            _ => return Err(WavError::Encoding { path: self.path.into(), tag, bits }),
        };
        if channels == 0 || rate == 0 {
            return Err(self.malformed(at, "the number of channels or the sample rate is zero"));
        }
        if u32::from(block) != u32::from(channels) * encoding.bytes() as u32 {
            return Err(self.malformed(at, "the size of a frame contradicts channels and bits"));
        }
        Ok((channels, rate, encoding))
    }

    /// The comment in a `LIST INFO` chunk of this size.
    fn parse_info(&mut self, size: u64) -> Result<Option<String>, WavError> {
        // A comment is a line or two; a longer list holds pictures or a transcript.
        const LONGEST: u64 = 1 << 16;
        if !(4..=LONGEST).contains(&size) || self.at + size > self.length {
            return Ok(None);
        }
        let mut list = vec![0; size as usize];
        self.fill(&mut list)?;
        let Some(mut rest) = list.strip_prefix(b"INFO") else { return Ok(None) };
        while let [a, b, c, d, s0, s1, s2, s3, tail @ ..] = rest {
            let size = u32::from_le_bytes([*s0, *s1, *s2, *s3]) as usize;
            let Some(content) = tail.get(..size) else { break };
            if [*a, *b, *c, *d] == *b"ICMT" {
                let text = content.split(|b| *b == 0).next().unwrap_or_default();
                return Ok(Some(String::from_utf8_lossy(text).into_owned()));
            }
            rest = tail.get(size + size % 2..).unwrap_or_default();
        }
        Ok(None)
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], WavError> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), WavError> {
        if self.at + bytes.len() as u64 > self.length {
            return Err(self.malformed(self.length, "the file ends inside its header"));
        }
        self.file.read_exact(bytes).map_err(|source| self.io_error(source))?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    fn go_to(&mut self, at: u64) -> Result<(), WavError> {
        self.file.seek(SeekFrom::Start(at)).map_err(|source| self.io_error(source))?;
        self.at = at;
        Ok(())
    }

    fn io_error(&self, source: std::io::Error) -> WavError {
        WavError::Io { action: "read", path: self.path.into(), source }
    }

    fn malformed(&self, at: u64, reason: &'static str) -> WavError {
        WavError::Malformed { path: self.path.into(), at, reason }
    }
}

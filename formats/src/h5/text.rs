//! Strings, of fixed and of variable length.

use hdf5::types::{FixedAscii, VarLenAscii, VarLenUnicode};

use super::dataset::{Dataset, Kind};
use crate::ReadError;

/// Longest string that is read [bytes]: a history of a million lines.
const MAX_TEXT_BYTES: usize = 1 << 26;

impl Dataset {
    /// The one string.
    pub(crate) fn text(&self) -> Result<String, ReadError> {
        let mut texts = self.texts()?;
        match (texts.pop(), texts.is_empty()) {
            (Some(text), true) => Ok(text),
            _ => Err(self.malformed(format!("has shape {:?}, must be one text", self.shape))),
        }
    }

    /// All strings; bytes that are no UTF-8 are replaced.
    pub(crate) fn texts(&self) -> Result<Vec<String>, ReadError> {
        match self.kind {
            Kind::FixedText(bytes) => self.fixed_texts(bytes),
            Kind::VariableText => self.variable_texts(),
            _ => Err(self.wrong_kind("text")),
        }
    }

    /// libhdf5 wants to know at compile time how long a string in memory is: the next size up.
    fn fixed_texts(&self, bytes: usize) -> Result<Vec<String>, ReadError> {
        match bytes {
            0..=64 => self.fixed::<64>(),
            65..=4096 => self.fixed::<4096>(),
            4097..=262_144 => self.fixed::<262_144>(),
            262_145..=4_194_304 => self.fixed::<4_194_304>(),
            4_194_305..=MAX_TEXT_BYTES => self.fixed::<MAX_TEXT_BYTES>(),
            _ => Err(self.unsupported(format!(
                "a text of {bytes} bytes; at most {MAX_TEXT_BYTES} are read"
            ))),
        }
    }

    fn fixed<const N: usize>(&self) -> Result<Vec<String>, ReadError> {
        // Few strings are longer than a line; each is read alone then, for the sake of memory.
        let count: usize = self.shape.iter().product();
        if N > 64 && count > 1 {
            self.prove_stored()?;
            let one = |i| self.read_converted::<FixedAscii<N>>(&[(i, 1)]);
            if self.shape.len() != 1 {
                return Err(self.malformed(format!("has shape {:?}, must be a list", self.shape)));
            }
            return (0..count)
                .map(|i| Ok(one(i)?.first().map(text).unwrap_or_default()))
                .collect();
        }
        Ok(self.read_all::<FixedAscii<N>>()?.iter().map(text).collect())
    }

    fn variable_texts(&self) -> Result<Vec<String>, ReadError> {
        self.check_texts()?;
        // The two encodings are one to the library's conversion only if asked for by name.
        if let Ok(texts) = self.read_all::<VarLenUnicode>() {
            return Ok(texts.iter().map(|t| lossy(t.as_bytes())).collect());
        }
        let texts = self.read_all::<VarLenAscii>()?;
        Ok(texts.iter().map(|t| lossy(t.as_bytes())).collect())
    }
}

fn text<const N: usize>(text: &FixedAscii<N>) -> String {
    lossy(text.as_bytes())
}

/// Up to the first NUL, as h5py pads with them.
fn lossy(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

#[cfg(test)]
mod tests {
    use super::super::Group;
    use hdf5::filters::Filter;
    use hdf5::types::VarLenUnicode;

    #[test]
    fn texts_of_any_length_are_read_whole_and_from_chunks() {
        let texts = ["", "a", "antenna", "twenty-four-letters-long", "b"];
        let values = texts.map(|text| text.parse::<VarLenUnicode>().unwrap());
        let packed = [Filter::shuffle(), Filter::deflate(1)];
        for (chunk, filters) in [(5, None), (2, None), (2, Some(&packed[..]))] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.h5");
            let file = hdf5::File::create(&path).unwrap();
            let data = ndarray::arr1(&values);
            let mut builder = file.new_dataset_builder().with_data(&data);
            if chunk < values.len() {
                builder = builder.chunk(chunk);
            }
            builder
                .set_filters(filters.unwrap_or_default())
                .create("a")
                .unwrap();
            drop(file);
            let found = Group::open(&path).unwrap().need("a").unwrap().texts();
            assert_eq!(found.unwrap(), texts, "{chunk}");
        }
    }
}

//! Open Sound Control 1.0 (Wright 2002): a message is its address, its type tags and its arguments, each padded to four
//! bytes; numbers are big-endian. One message a datagram, without bundles, which some receivers ignore.

pub(crate) mod layouts;

/// An argument of a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OscArgument {
    /// `i`.
    Int(i32),
    /// `f`.
    Float(f32),
}

/// One OSC message: an address and its arguments.
#[derive(Debug, Clone, PartialEq)]
pub struct OscMessage {
    /// Begins with `/`.
    pub address: String,
    /// In order.
    pub arguments: Vec<OscArgument>,
}

impl OscMessage {
    /// A message of floats.
    fn floats(address: String, values: impl IntoIterator<Item = f64>) -> Self {
        let values = values.into_iter().map(crate::narrowed);
        Self {
            address,
            arguments: values.map(OscArgument::Float).collect(),
        }
    }

    /// The bytes of the datagram that carries the message.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let tags = self.arguments.iter().map(|argument| match argument {
            OscArgument::Int(_) => 'i',
            OscArgument::Float(_) => 'f',
        });
        let mut bytes = padded(&self.address);
        bytes.extend(padded(&format!(",{}", tags.collect::<String>())));
        for argument in &self.arguments {
            bytes.extend(match argument {
                OscArgument::Int(value) => value.to_be_bytes(),
                OscArgument::Float(value) => value.to_be_bytes(),
            });
        }
        bytes
    }
}

/// A string with one to four zero bytes behind it, to a multiple of four bytes.
fn padded(text: &str) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize((bytes.len() / 4 + 1) * 4, 0);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first example of the specification's section "OSC Message Examples".
    #[test]
    fn a_message_has_the_bytes_of_the_specification() {
        let message = OscMessage {
            address: "/oscillator/4/frequency".to_owned(),
            arguments: vec![OscArgument::Float(440.0)],
        };
        let mut expected = b"/oscillator/4/frequency\0,f\0\0".to_vec();
        expected.extend([0x43, 0xdc, 0, 0]);
        assert_eq!(message.to_bytes(), expected);
    }

    #[test]
    fn text_of_four_bytes_gets_four_zeros() {
        assert_eq!(padded("/abc"), b"/abc\0\0\0\0");
        assert_eq!(padded("/ab"), b"/ab\0");
    }
}

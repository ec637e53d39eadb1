//! Encoding and decoding of payloads: the four-byte header, the body, and an error for each way to be wrong.

use crate::check::OutOfRange;
use crate::limits::MAX_PAYLOAD_BYTES;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// First byte of every payload: `S`.
pub const MAGIC: u8 = 0x53;
/// Version of the contract; a changed message is a new one.
pub const VERSION: u8 = 1;
/// Magic, version, kind, flags.
pub const HEADER_BYTES: usize = 4;

/// What a payload holds: its third byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum MessageKind {
    /// [`crate::Observations`]
    Observations = 1,
    /// [`crate::Preview`]
    Preview = 2,
    /// [`crate::DetectionReport`]
    DetectionReport = 3,
    /// [`crate::CameraStatus`]
    CameraStatus = 4,
    /// [`crate::ObjectPose`]
    ObjectPose = 5,
    /// [`crate::ObjectLinks`]
    ObjectLinks = 6,
    /// [`crate::ObjectTruth`]
    ObjectTruth = 7,
    /// [`crate::FusionStatus`]
    FusionStatus = 8,
    /// [`crate::ClockReport`]
    ClockReport = 9,
    /// [`crate::ConfigAnswer`]
    ConfigAnswer = 10,
    /// [`crate::Proposal`]
    Proposal = 11,
    /// [`crate::RigConfig`]
    RigConfig = 12,
    /// [`crate::ObjectConfig`]
    ObjectConfig = 13,
    /// [`crate::FusionInputs`]
    FusionInputs = 14,
    /// [`crate::CameraSettings`]
    CameraSettings = 15,
    /// [`crate::Heartbeat`]
    Heartbeat = 16,
}

impl MessageKind {
    /// Every kind, by number.
    pub const ALL: [Self; 16] = [
        Self::Observations,
        Self::Preview,
        Self::DetectionReport,
        Self::CameraStatus,
        Self::ObjectPose,
        Self::ObjectLinks,
        Self::ObjectTruth,
        Self::FusionStatus,
        Self::ClockReport,
        Self::ConfigAnswer,
        Self::Proposal,
        Self::RigConfig,
        Self::ObjectConfig,
        Self::FusionInputs,
        Self::CameraSettings,
        Self::Heartbeat,
    ];

    /// Longest payload of this kind, header included.
    #[must_use]
    pub const fn max_bytes(self) -> usize {
        match self {
            Self::Observations => 80 * 1024,
            Self::Heartbeat => 96 * 1024,
            Self::Preview => 100 * 1024,
            Self::DetectionReport => 4 * 1024,
            Self::CameraStatus => 8 * 1024,
            Self::ObjectPose | Self::ObjectTruth | Self::CameraSettings => 1024,
            Self::ObjectLinks | Self::FusionInputs | Self::ConfigAnswer => 16 * 1024,
            Self::ClockReport => 32 * 1024,
            Self::FusionStatus | Self::RigConfig | Self::ObjectConfig | Self::Proposal => {
                MAX_PAYLOAD_BYTES
            }
        }
    }

    /// The kind of that number.
    #[must_use]
    pub fn from_byte(byte: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == byte)
    }
}

/// A message of the contract.
pub trait Message: Serialize + DeserializeOwned {
    /// The kind in the header.
    const KIND: MessageKind;

    /// Whether every value lies in its documented range.
    ///
    /// # Errors
    /// Names the first field that does not.
    fn check(&self) -> Result<(), OutOfRange>;
}

/// Why a message is not encoded.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EncodeError {
    /// A value out of its range, or not finite.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// More bytes than its kind allows.
    #[error("{bytes} bytes are more than the {max} that a {kind:?} may have")]
    TooLong {
        /// The kind.
        kind: MessageKind,
        /// Its length, header included.
        bytes: usize,
        /// What [`MessageKind::max_bytes`] allows.
        max: usize,
    },
    /// The serialiser refused.
    #[error("the message cannot be serialised")]
    Unserialisable,
}

/// Why bytes are not a message of the expected kind.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// More bytes than the kind allows; they were not read.
    #[error("the payload of {0} bytes is longer than allowed")]
    TooLong(usize),
    /// No header, or another first byte: not a payload of ours.
    #[error("not a Sextant payload: it does not begin with the magic byte")]
    BadMagic,
    /// Another version of the contract.
    #[error("version {0} of the contract is not known here (this is version {VERSION})")]
    ForeignVersion(u8),
    /// Flags that this version does not define.
    #[error("flags {0:#04x} are not known here")]
    UnknownFlags(u8),
    /// A message of another kind, or of none.
    #[error("kind {found} where {expected:?} was expected")]
    WrongKind {
        /// What the key promises.
        expected: MessageKind,
        /// The header's third byte.
        found: u8,
    },
    /// The body ends early or makes no sense.
    #[error("the payload is damaged")]
    Damaged,
    /// Bytes after the message.
    #[error("{0} bytes follow the message")]
    TrailingBytes(usize),
    /// A whole message with a value out of its range.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
}

/// The payload of a message.
///
/// # Errors
/// A value out of its range, or more than fits.
pub fn encode<M: Message>(message: &M) -> Result<Vec<u8>, EncodeError> {
    let mut payload = Vec::new();
    encode_into(message, &mut payload)?;
    Ok(payload)
}

/// Like [`encode`], into a buffer that is cleared first: for senders that keep one. On an error it is left empty.
///
/// # Errors
/// A value out of its range, or more than fits.
pub fn encode_into<M: Message>(message: &M, payload: &mut Vec<u8>) -> Result<(), EncodeError> {
    payload.clear();
    message.check()?;
    payload.extend_from_slice(&[MAGIC, VERSION, M::KIND as u8, 0]);
    let written = postcard::to_extend(message, std::mem::take(payload));
    let mut filled = written.map_err(|_| EncodeError::Unserialisable)?;
    let (bytes, max) = (filled.len(), M::KIND.max_bytes());
    if bytes > max {
        filled.clear();
        *payload = filled;
        return Err(EncodeError::TooLong {
            kind: M::KIND,
            bytes,
            max,
        });
    }
    *payload = filled;
    Ok(())
}

/// The message of a payload.
///
/// # Errors
/// Anything but a whole, sane message of this kind and version.
pub fn decode<M: Message>(payload: &[u8]) -> Result<M, DecodeError> {
    if payload.len() > M::KIND.max_bytes() {
        return Err(DecodeError::TooLong(payload.len()));
    }
    let (kind, body) = open(payload)?;
    if kind != M::KIND as u8 {
        return Err(DecodeError::WrongKind {
            expected: M::KIND,
            found: kind,
        });
    }
    let (message, rest) = postcard::take_from_bytes::<M>(body).map_err(|_| DecodeError::Damaged)?;
    if !rest.is_empty() {
        return Err(DecodeError::TrailingBytes(rest.len()));
    }
    message.check()?;
    Ok(message)
}

/// The kind's byte and the body behind a header of this version.
pub(crate) fn open(payload: &[u8]) -> Result<(u8, &[u8]), DecodeError> {
    let Some((&[magic, version, kind, flags], body)) = payload.split_first_chunk() else {
        return Err(DecodeError::BadMagic);
    };
    if magic != MAGIC {
        return Err(DecodeError::BadMagic);
    }
    if version != VERSION {
        return Err(DecodeError::ForeignVersion(version));
    }
    if flags != 0 {
        return Err(DecodeError::UnknownFlags(flags));
    }
    Ok((kind, body))
}

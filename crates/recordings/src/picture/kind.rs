//! What a file is by its first bytes, whatever its name says.

/// How many bytes [`PictureKind::from_head`] looks at.
pub(super) const HEAD: usize = 32;

/// A kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PictureKind {
    Png,
    Jpeg,
    Pnm,
    Webp,
    Tiff,
    Bmp,
    /// Known, and not read: with an article.
    Other(&'static str),
    /// The beginning of nothing that is known.
    Unknown,
    Empty,
}

/// Beginnings that settle the matter.
const BEGINNINGS: &[(&[u8], PictureKind)] = &[
    (b"\x89PNG\r\n\x1a\n", PictureKind::Png),
    (b"\xff\xd8\xff", PictureKind::Jpeg),
    (
        b"II*\0\x10\0\0\0CR",
        PictureKind::Other("a raw picture (CR2)"),
    ),
    (b"II*\0", PictureKind::Tiff),
    (b"MM\0*", PictureKind::Tiff),
    (b"II+\0", PictureKind::Tiff),
    (b"MM\0+", PictureKind::Tiff),
    (b"GIF8", PictureKind::Other("a GIF picture")),
    (b"\xff\x0a", PictureKind::Other("a JPEG XL picture")),
    (b"\0\0\0\x0cJXL ", PictureKind::Other("a JPEG XL picture")),
    (b"\0\0\0\x0cjP  ", PictureKind::Other("a JPEG 2000 picture")),
    (
        b"\xff\x4f\xff\x51",
        PictureKind::Other("a JPEG 2000 picture"),
    ),
    (
        b"\x76\x2f\x31\x01",
        PictureKind::Other("an OpenEXR picture"),
    ),
    (b"8BPS", PictureKind::Other("a Photoshop picture")),
    (
        b"FUJIFILMCCD-RAW",
        PictureKind::Other("a raw picture (RAF)"),
    ),
    (b"<svg", PictureKind::Other("an SVG drawing")),
    (b"%PDF", PictureKind::Other("a PDF document")),
    (b"PK\x03\x04", PictureKind::Other("a ZIP archive")),
    (b"\x1f\x8b", PictureKind::Other("a file packed with gzip")),
    (
        b"\x1a\x45\xdf\xa3",
        PictureKind::Other("a video (Matroska or WebM)"),
    ),
    (b"\x89MCAP0\r\n", PictureKind::Other("an MCAP recording")),
];

impl PictureKind {
    /// Whether it is a picture of a kind that is read.
    pub(super) fn is_read(self) -> bool {
        !matches!(self, Self::Other(_) | Self::Unknown | Self::Empty)
    }

    /// The kind of the file that begins so.
    pub(super) fn from_head(head: &[u8]) -> Self {
        if head.is_empty() {
            return Self::Empty;
        }
        let settled = BEGINNINGS.iter().find(|(start, _)| head.starts_with(start));
        if let Some((_, kind)) = settled {
            return *kind;
        }
        match (head.get(..4), head.get(4..8), head.get(8..12)) {
            (Some(b"RIFF"), Some(_), Some(b"WEBP")) => Self::Webp,
            (Some(b"RIFF"), Some(_), Some(b"AVI ")) => Self::Other("a video (AVI)"),
            (Some(_), Some(b"ftyp"), Some(brand)) => Self::Other(of_brand(brand)),
            _ if is_pnm(head) => Self::Pnm,
            _ if is_bmp(head) => Self::Bmp,
            _ => Self::Unknown,
        }
    }
}

/// What the first brand of an ISO media file stands for.
fn of_brand(brand: &[u8]) -> &'static str {
    match brand {
        b"heic" | b"heix" | b"heim" | b"heis" | b"hevc" | b"hevx" | b"mif1" | b"msf1" => {
            "a HEIC picture"
        }
        b"avif" | b"avis" => "an AVIF picture",
        b"crx " => "a raw picture (CR3)",
        _ => "a video (MP4 or MOV)",
    }
}

fn is_pnm(head: &[u8]) -> bool {
    matches!(head, [b'P', b'1'..=b'7', then, ..] if then.is_ascii_whitespace() || *then == b'#')
}

/// `BM` alone would be the beginning of many a text; the header of a bitmap has four bytes of zeros.
fn is_bmp(head: &[u8]) -> bool {
    head.starts_with(b"BM") && head.get(6..10) == Some(&[0; 4])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_their_first_bytes() {
        for (head, kind) in [
            (&b""[..], PictureKind::Empty),
            (b"hello, this is text", PictureKind::Unknown),
            (b"BMW and others", PictureKind::Unknown),
            (b"BM\x46\0\0\0\0\0\0\0\x36\0\0\0", PictureKind::Bmp),
            (b"P5\n2 2\n255\n", PictureKind::Pnm),
            (b"P5x", PictureKind::Unknown),
            (b"RIFF\x1a\0\0\0WEBPVP8L", PictureKind::Webp),
            (b"MM\0*\0\0\0\x08", PictureKind::Tiff),
            (b"\0\0\0\x18ftypheic", PictureKind::Other("a HEIC picture")),
            (b"\0\0\0\x18ftypavif", PictureKind::Other("an AVIF picture")),
            (
                b"\0\0\0\x18ftypisom",
                PictureKind::Other("a video (MP4 or MOV)"),
            ),
        ] {
            assert_eq!(PictureKind::from_head(head), kind, "{head:?}");
        }
    }
}

//! Numbers of the driver's requests. Their size field is always 4, whatever the record's size: they cannot be derived
//! from types.

/// Bytes of every record that is handed to the driver; it copies at most as many, whatever it needs.
pub const RECORD_BYTES: usize = 256;
/// A record: little-endian words in, little-endian words out over the same bytes.
pub type Record = [u8; RECORD_BYTES];

/// Initialises the hardware, once. Out: result.
pub const INIT: u32 = 0x8004_c121;
/// Never used: a later INIT reports success and does nothing.
pub const UNINIT: u32 = 0x8004_c122;
/// Loads a circuit. In: address of its data, mask of top tiles, tile pattern, 0, 0. Out: result, identifiers of six
/// tiles.
pub const LOAD: u32 = 0xc004_c123;
/// Unloads circuits. In: identifier, 0 for all. Out: result, identifiers of six tiles.
pub const UNLOAD: u32 = 0xc004_c124;
/// Activates circuits. In: mask of identifiers, frequency 0. Out: result.
pub const ACTIVATE: u32 = 0xc004_c125;
/// Never used: the driver always answers INTERNAL.
pub const INACTIVATE: u32 = 0xc004_c126;
/// Starts a circuit. In: identifier, size of parameters, parameters. Out: result.
pub const START: u32 = 0xc004_c127;
/// Status of a circuit. In: identifier. Out: 1 loaded, 2 activated, 3 started.
pub const GETSTATUS: u32 = 0xc004_c128;
/// Never used: the driver follows a pointer of user space.
pub const GETINFO: u32 = 0xc004_c129;
/// Version of the driver. Out: version.
pub const GETVERSION: u32 = 0x8004_c12a;
/// Waits until circuits have ended. In: mask of top tiles, milliseconds, 0. Out: result.
pub const WAIT: u32 = 0x8004_c12b;
/// Makes circuit data known. In: address, size, whether to copy it to RAM. Out: result, address of the copy.
pub const MAP: u32 = 0x8004_c12c;

//! The packets of docs/udp.md: little-endian, fixed layout, CRC-32 at the end.

/// First four bytes of every packet.
pub const MAGIC: [u8; 4] = *b"ROMU";
/// Version of the layout.
pub const VERSION: u16 = 1;
/// Bytes before the payload.
pub const HEADER: usize = 24;
/// Bytes of the checksum after it.
pub const CHECKSUM: usize = 4;
/// Bytes of a wrench in a step request.
pub const WRENCH: usize = 56;
/// Most bytes that a datagram can have.
pub const LARGEST: usize = 65_507;
/// Set in the kind of a reply.
pub const REPLY: u16 = 0x8000;
/// Kind of a reply that says why a request was not done.
pub const ERROR: u16 = 0xffff;

/// What a host asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Begins a session.
    Hello = 1,
    /// A name.
    Name = 2,
    /// Steps under wrenches.
    Step = 3,
    /// The outputs as they are.
    Read = 4,
    /// Back to the start.
    Reset = 5,
    /// Saves the state.
    Snapshot = 6,
    /// Goes back to a saved one.
    Restore = 7,
}

impl Kind {
    const ALL: [Kind; 7] =
        [Kind::Hello, Kind::Name, Kind::Step, Kind::Read, Kind::Reset, Kind::Snapshot, Kind::Restore];
}

/// A request that is well-formed; its payload has still to be looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request<'a> {
    /// What is asked for.
    pub kind: Kind,
    /// Chosen by the host.
    pub session: u32,
    /// Of the packet in its session.
    pub sequence: u32,
    /// What belongs to the kind.
    pub payload: &'a [u8],
    /// Checksum of the whole, which tells a packet sent again from another one.
    pub checksum: u32,
}

/// Why a packet is ignored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Malformed {
    /// Shorter than a header, or not as long as it says.
    Length,
    /// Another protocol.
    Magic,
    /// Another version of this one.
    Version,
    /// Damaged.
    Checksum,
    /// Something that hosts do not ask for.
    Kind,
}

/// Takes a packet apart.
///
/// # Errors
/// What is wrong with it.
pub fn parse(packet: &[u8]) -> Result<Request<'_>, Malformed> {
    let (header, rest) = packet.split_first_chunk::<HEADER>().ok_or(Malformed::Length)?;
    let (payload, checksum) = rest.split_last_chunk::<CHECKSUM>().ok_or(Malformed::Length)?;
    if header[..4] != MAGIC {
        return Err(Malformed::Magic);
    }
    if u16_at(header, 4) != Some(VERSION) {
        return Err(Malformed::Version);
    }
    let number = |at| u32_at(header, at).ok_or(Malformed::Length);
    if number(16)? as usize != payload.len() {
        return Err(Malformed::Length);
    }
    let checksum = u32::from_le_bytes(*checksum);
    if crc32fast::hash(&packet[..packet.len() - CHECKSUM]) != checksum {
        return Err(Malformed::Checksum);
    }
    let kind = u16_at(header, 6);
    let kind = Kind::ALL.into_iter().find(|known| Some(*known as u16) == kind).ok_or(Malformed::Kind)?;
    Ok(Request { kind, session: number(8)?, sequence: number(12)?, payload, checksum })
}

/// Puts a packet together in memory that is kept.
#[derive(Debug)]
pub struct Writer {
    bytes: Vec<u8>,
}

impl Default for Writer {
    fn default() -> Self {
        Self { bytes: Vec::with_capacity(LARGEST) }
    }
}

impl Writer {
    /// Begins a packet.
    pub fn begin(&mut self, kind: u16, session: u32, sequence: u32) {
        self.bytes.clear();
        self.bytes.extend(MAGIC);
        self.bytes.extend(VERSION.to_le_bytes());
        self.bytes.extend(kind.to_le_bytes());
        self.bytes.extend(session.to_le_bytes());
        self.bytes.extend(sequence.to_le_bytes());
        self.bytes.extend([0; 8]);
    }

    /// Appends to the payload.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// Appends numbers.
    pub fn floats<'a>(&mut self, values: impl IntoIterator<Item = &'a f64>) {
        values.into_iter().for_each(|value| self.bytes.extend(value.to_le_bytes()));
    }

    /// Appends whole numbers.
    pub fn words(&mut self, values: &[u32]) {
        values.iter().for_each(|value| self.bytes.extend(value.to_le_bytes()));
    }

    /// Appends a text of at most so many bytes, cut between characters.
    pub fn text(&mut self, text: &str, most: usize) {
        let end = (0..=text.len().min(most)).rev().find(|end| text.is_char_boundary(*end)).unwrap_or(0);
        self.bytes.extend_from_slice(&text.as_bytes()[..end]);
    }

    /// Ends the packet: length and checksum.
    pub fn finish(&mut self) -> &[u8] {
        let length = (self.bytes.len() - HEADER) as u32;
        self.bytes[16..20].copy_from_slice(&length.to_le_bytes());
        let checksum = crc32fast::hash(&self.bytes);
        self.bytes.extend(checksum.to_le_bytes());
        &self.bytes
    }

    /// The packet made last.
    pub fn last(&self) -> &[u8] {
        &self.bytes
    }
}

/// Two bytes at a place.
pub fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|chunk| u16::from_le_bytes(*chunk))
}

/// Four bytes at a place.
pub fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|chunk| u32::from_le_bytes(*chunk))
}

/// Numbers at a place.
pub fn floats_at<const N: usize>(bytes: &[u8], at: usize) -> Option<[f64; N]> {
    let bytes = bytes.get(at..at.checked_add(8 * N)?)?;
    let mut values = [0.0; N];
    for (value, chunk) in values.iter_mut().zip(bytes.chunks_exact(8)) {
        *value = f64::from_le_bytes(*chunk.first_chunk()?);
    }
    Some(values)
}

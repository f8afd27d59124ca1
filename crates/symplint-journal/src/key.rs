//! What a call of a map is known by.

use symplint::Block;

/// The beginning of the SHA-256 of a step size and states: two calls that differ have the same with a probability of
/// 2^-128.
pub type Key = [u8; 16];

/// The key of a call with these states.
pub fn key(h: f64, block: &Block<'_>) -> Key {
    let mut hash = hmac_sha256::Hash::new();
    hash.update(h.to_bits().to_le_bytes());
    for size in [block.dof(), block.len()] {
        hash.update((size as u64).to_le_bytes());
    }
    for rows in [&block.q, &block.p] {
        for i in 0..block.dof() {
            let bytes: Vec<u8> = rows
                .row(i)
                .iter()
                .flat_map(|x| x.to_bits().to_le_bytes())
                .collect();
            hash.update(bytes);
        }
    }
    let mut key = [0; 16];
    key.copy_from_slice(&hash.finalize()[..16]);
    key
}

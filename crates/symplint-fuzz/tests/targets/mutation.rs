//! Mutations of inputs, by random numbers of a seed.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::Rng;

/// What formats are made of, and what readers may trip over.
const TOKENS: [&[u8]; 24] = [
    b"\0",
    b"\n",
    b"[",
    b"]",
    b"{",
    b"}",
    b",",
    b"\"",
    b"'",
    b"(",
    b"=",
    b"#",
    b"nan",
    b"-inf",
    b"1e999",
    b"-0.0",
    b"1e-320",
    b"0",
    b"99999999999999999999",
    b"18446744073709551615",
    b"null",
    b"auto",
    b"2^-1074",
    "π".as_bytes(),
];

/// Longest input.
const MAX_LENGTH: usize = 1 << 17;

/// One of the inputs with some changes: bits, cuts, parts of others, repeated parts, tokens.
pub fn of(inputs: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = inputs[below(random, inputs.len())].clone();
    for _ in 0..=below(random, 4) {
        let place = below(random, bytes.len() + 1);
        let end = (place + 1 + below(random, 32)).min(bytes.len());
        match below(random, 6) {
            0 => {
                if let Some(byte) = bytes.get_mut(place) {
                    *byte ^= 1 << below(random, 8);
                }
            }
            1 => bytes.truncate(place),
            2 => drop(bytes.drain(place..end)),
            3 => {
                let other = &inputs[below(random, inputs.len())];
                let from = below(random, other.len() + 1);
                bytes.splice(place.., other[from..].iter().copied());
            }
            4 => {
                let part = bytes[place..end].repeat(1 + below(random, 64));
                bytes.splice(place..place, part);
            }
            _ => {
                let token = TOKENS[below(random, TOKENS.len())];
                let replaced = if random.next_u32().is_multiple_of(2) {
                    end
                } else {
                    place
                };
                bytes.splice(place..replaced, token.iter().copied());
            }
        }
    }
    bytes.truncate(MAX_LENGTH);
    bytes
}

fn below(random: &mut ChaCha8Rng, count: usize) -> usize {
    (random.next_u64() % count as u64) as usize
}

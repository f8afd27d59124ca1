//! The functions that a page calls. Texts are UTF-8 in the memory of the module, at an address and of a length.

use std::alloc::{Layout, alloc, dealloc};
use std::slice;

/// Bytes before an answer that state its length.
const PREFIX: usize = size_of::<u32>();

/// The memory of `length` bytes, from its first.
fn layout(length: usize) -> Option<Layout> {
    Layout::array::<u8>(length.max(1)).ok()
}

/// Memory for a text; null if the memory is full.
#[unsafe(no_mangle)]
pub extern "C" fn symplint_allocate(length: usize) -> *mut u8 {
    match layout(length) {
        // SAFETY: the layout is not empty.
        Some(layout) => unsafe { alloc(layout) },
        None => std::ptr::null_mut(),
    }
}

/// Frees the room for a text.
///
/// # Safety
/// `text` is from `symplint_allocate` with the same length, and not freed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_free(text: *mut u8, length: usize) {
    if let Some(layout) = layout(length).filter(|_| !text.is_null()) {
        // SAFETY: the caller got the memory from `symplint_allocate`, which used this layout.
        unsafe { dealloc(text, layout) };
    }
}

/// The answer to a configuration: four bytes of its length, little-endian, and its text. Null if memory for it is missing. The caller
/// frees it with the length plus four.
///
/// # Safety
/// `text` is the address of `length` bytes that do not change during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_answer(text: *const u8, length: usize) -> *mut u8 {
    // SAFETY: the caller's promise.
    let bytes = unsafe { slice::from_raw_parts(text, length) };
    let answer = crate::answer::answer(&String::from_utf8_lossy(bytes));
    let room = symplint_allocate(PREFIX + answer.len());
    if let (false, Ok(length)) = (room.is_null(), u32::try_from(answer.len())) {
        // SAFETY: the room was just allocated with this length.
        let to = unsafe { slice::from_raw_parts_mut(room, PREFIX + answer.len()) };
        to[..PREFIX].copy_from_slice(&length.to_le_bytes());
        to[PREFIX..].copy_from_slice(answer.as_bytes());
    }
    room
}

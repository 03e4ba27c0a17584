//! Values of variables, by their types.

use core::ffi::{c_char, c_void};
use std::ffi::CString;

use coaxle_fmi::{UnitValue, ValueKind};

use crate::instance::{FmiStatus, InstanceHandle, Refused, call};
use crate::memory::{array, array_to_write, text};

/// Declares the two functions of a type that variables have.
macro_rules! accessors {
    ($($get:ident $set:ident $kind:ident $type:ty, of $given:ty: $checked:expr;)*) => {$(
        #[doc = concat!("Reads variables of the type ", stringify!($kind), ".")]
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: *mut c_void,
            references: *const u32,
            number_of_references: usize,
            values: *mut $type,
            number: usize,
        ) -> FmiStatus {
            // SAFETY: as for this function.
            unsafe {
                call(instance, |handle| {
                    let references = array(references, number_of_references, "valueReferences")?;
                    let values = array_to_write(values, number, "values")?;
                    check_number(references, values.len())?;
                    for (reference, place) in references.iter().zip(values) {
                        handle.instance.check_type(*reference, ValueKind::$kind)?;
                        if let UnitValue::$kind(value) = handle.instance.get(*reference)? {
                            *place = *value;
                        }
                    }
                    Ok(())
                })
            }
        }

        #[doc = concat!("Sets variables of the type ", stringify!($kind), ".")]
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: *mut c_void,
            references: *const u32,
            number_of_references: usize,
            values: *const $given,
            number: usize,
        ) -> FmiStatus {
            // SAFETY: as for this function.
            unsafe {
                call(instance, |handle| {
                    let references = array(references, number_of_references, "valueReferences")?;
                    let values = array(values, number, "values")?;
                    check_number(references, values.len())?;
                    for (reference, value) in references.iter().zip(values) {
                        handle.instance.set(*reference, UnitValue::$kind($checked(*value)))?;
                    }
                    Ok(())
                })
            }
        }
    )*};
}

accessors! {
    fmi3GetFloat64 fmi3SetFloat64 Float64 f64, of f64: |value| value;
    fmi3GetInt64 fmi3SetInt64 Int64 i64, of i64: |value| value;
    fmi3GetUInt64 fmi3SetUInt64 UInt64 u64, of u64: |value| value;
    // As a byte: any other than 0 and 1 would be no `bool`.
    fmi3GetBoolean fmi3SetBoolean Boolean bool, of u8: |value| value != 0;
}

/// Reads texts, which stay until the next call of this function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetString(
    instance: *mut c_void,
    references: *const u32,
    number_of_references: usize,
    values: *mut *const c_char,
    number: usize,
) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |handle| {
            let references = array(references, number_of_references, "valueReferences")?;
            let values = array_to_write(values, number, "values")?;
            check_number(references, values.len())?;
            handle.texts.clear();
            for (reference, place) in references.iter().zip(values) {
                let text = text_of(handle, *reference)?;
                // What it points to stays where it is while the list grows.
                *place = text.as_ptr();
                handle.texts.push(text);
            }
            Ok(())
        })
    }
}

fn text_of(handle: &InstanceHandle, reference: u32) -> Result<CString, Refused> {
    handle.instance.check_type(reference, ValueKind::String)?;
    Ok(match handle.instance.get(reference)? {
        // A text that was set had no zero, and words have none.
        UnitValue::String(text) => CString::new(text.as_str()).unwrap_or_default(),
        _ => CString::default(),
    })
}

/// Sets texts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetString(
    instance: *mut c_void,
    references: *const u32,
    number_of_references: usize,
    values: *const *const c_char,
    number: usize,
) -> FmiStatus {
    // SAFETY: as for this function.
    unsafe {
        call(instance, |handle| {
            let references = array(references, number_of_references, "valueReferences")?;
            let values = array(values, number, "values")?;
            check_number(references, values.len())?;
            for (reference, value) in references.iter().zip(values) {
                let value = text(*value, "values")?;
                handle.instance.set(*reference, UnitValue::String(value))?;
            }
            Ok(())
        })
    }
}

/// Checks that there is one value for each reference: variables are scalars.
fn check_number(references: &[u32], number: usize) -> Result<(), Refused> {
    if references.len() == number {
        return Ok(());
    }
    let expected = format!("{}, one for each reference", references.len());
    Err(Refused::of("nValues", number, expected))
}

/// Declares functions of types that no variable has.
macro_rules! absent_types {
    ($($name:ident)*) => {$(
        /// Refuses: no variable of a unit has this type.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            instance: *mut c_void,
            _references: *const u32,
            number_of_references: usize,
        ) -> FmiStatus {
            // SAFETY: as for this function. Further arguments are not read, and belong to the caller.
            unsafe {
                call(instance, |_| match number_of_references {
                    0 => Ok(()),
                    number => {
                        let expected = "none: variables are Float64, Int64, UInt64, Boolean and String";
                        let received = format!("{number} value references");
                        Err(Refused::of(stringify!($name), received, expected))
                    }
                })
            }
        }
    )*};
}

absent_types! {
    fmi3GetFloat32 fmi3SetFloat32 fmi3GetInt8 fmi3SetInt8 fmi3GetUInt8 fmi3SetUInt8 fmi3GetInt16 fmi3SetInt16
    fmi3GetUInt16 fmi3SetUInt16 fmi3GetInt32 fmi3SetInt32 fmi3GetUInt32 fmi3SetUInt32 fmi3GetBinary fmi3SetBinary
    fmi3GetClock fmi3SetClock
}

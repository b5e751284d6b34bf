//! Access to memory-mapped registers.

#[derive(Debug)]
pub(crate) struct Register(usize);

impl Register {
    /// # Safety
    /// There is a 32-bit register at this address, and reading or writing it breaks no rule of memory.
    #[expect(unsafe_code, reason = "whoever names an address answers for it")]
    pub(crate) const unsafe fn at(address: usize) -> Self {
        Self(address)
    }

    const fn pointer(&self) -> *mut u32 {
        self.0 as *mut u32
    }

    pub(crate) fn read(&self) -> u32 {
        #[expect(unsafe_code, reason = "a register is read")]
        // SAFETY: as promised to `at`.
        unsafe {
            self.pointer().read_volatile()
        }
    }

    pub(crate) fn write(&self, value: u32) {
        #[expect(unsafe_code, reason = "a register is written")]
        // SAFETY: as promised to `at`.
        unsafe {
            self.pointer().write_volatile(value);
        }
    }
}

/* A bare image for an Arm MPS2 (Cortex-M4F) in QEMU: runs the operator, prints the hash of the outputs and the instructions
 * of its dearest step through the debugger's channel. */
#include <stdint.h>

#define SAMPLES 100000U

static op_t op;

/* A sample of an operator, or of a controller whose actuator does half: that takes its dearest way. */
#ifdef CHANGE
static REAL step(REAL x)
{
    const REAL u = op_output(&op, (REAL)1, x);
    op_advance(&op, (REAL)1, x, (REAL)0.5 * u);
    return u;
}
#else
static REAL step(REAL x)
{
    return op_step(&op, x);
}
#endif

uint64_t run(uint32_t samples);
void reset(void);
extern uint32_t stack_top;

static volatile uint32_t *const SYST_CSR = (volatile uint32_t *)0xE000E010;
static volatile uint32_t *const SYST_RVR = (volatile uint32_t *)0xE000E014;
static volatile uint32_t *const SYST_CVR = (volatile uint32_t *)0xE000E018;
static volatile uint32_t *const CPACR = (volatile uint32_t *)0xE000ED88;

static uint32_t semihosting(uint32_t operation, const void *argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void print_hex(uint64_t value)
{
    char text[18];
    uint32_t i;
    for (i = 0U; i < 16U; ++i) {
        text[i] = "0123456789abcdef"[(value >> (60U - 4U * i)) & 15U];
    }
    text[16] = '\n';
    text[17] = '\0';
    (void)semihosting(0x04U, text);
}

/* Instructions of the dearest of 1000 steps: QEMU takes 64 ns for each, SysTick counts every 40 ns. */
static uint32_t dearest(void)
{
    uint32_t most = 0U;
    uint32_t n;
    REAL x = 0;
    *SYST_RVR = 0x00FFFFFFU;
    *SYST_CVR = 0U;
    *SYST_CSR = 5U;
    op_init(&op);
    for (n = 0U; n < 1000U; ++n) {
        uint32_t before;
        uint32_t counts;
        volatile REAL y;
        x += (n < 500U) ? (REAL)1 / (REAL)1024 : (REAL)0;
        before = *SYST_CVR;
        y = step(x);
        counts = (before - *SYST_CVR) & 0x00FFFFFFU;
        (void)y;
        if (counts > most) {
            most = counts;
        }
    }
    return (5U * most + 4U) / 8U;
}

void reset(void)
{
    static const uint32_t exit_reason[2] = {0x20026U, 0U};
    *CPACR |= 0x00F00000U;
    __asm__ volatile("dsb\n\tisb");
    print_hex(run(SAMPLES));
    print_hex(dearest());
    (void)semihosting(0x20U, exit_reason);
    for (;;) {
    }
}

typedef struct {
    uint32_t *stack;
    void (*reset)(void);
} vectors_t;

__attribute__((section(".vectors"), used)) static const vectors_t vectors = {&stack_top, reset};

/* Prints what the guide's oven, asked for 3 K, has after half an hour, by an actuator that gives this share of the command in so
 * many counts of 10 W, reported unless the counts are negative; and how far it then moves in an hour after a settle. */
#include <stdio.h>
#include <stdlib.h>

static op_t op;
static double y;
static double late[5];

static float tick(unsigned n, double share, double counts)
{
    volatile float zero = 0;
    const float u = op_output(&op, 3, (float)y);
    const double most = (counts > 0) ? counts : 1e9;
    const double given = (double)(long)(share * (double)u / 10 * most + 0.5) * 10 / most;
    op_advance(&op, 3, (float)y, (counts < 0) ? zero / zero : (float)given);
    y += 0.2 / 62 * (0.55 * late[n % 5U] - y);
    late[n % 5U] = given;
    return u;
}

int main(int count, char **values)
{
    const double share = atof(values[count - 2]);
    const double counts = atof(values[count - 1]);
    double moved = 0;
    unsigned n;
    op_init(&op);
    for (n = 0; n < 9000; ++n) {
        tick(n, share, counts);
    }
    printf("%.4f ", y);
    y = 3;
    for (n = 0; n < 5; ++n) {
        late[n] = 3 / 0.55;
    }
    op_settle(&op, 3, 3, (float)late[0]);
    for (n = 0; n < 18000; ++n) {
        tick(n, 1, 0);
        moved = (y - 3 > moved) ? y - 3 : ((3 - y > moved) ? 3 - y : moved);
    }
    printf("%.1e\n", moved);
    return 0;
}

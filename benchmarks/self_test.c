/* Workload W2, the PN self-test of the accelerometer, sample by sample with the operations in the stated order.
   ad[4], bd[2]: exact hold of the device; h: periods x 16 sums. */
#include <math.h>
#include <stdint.h>

void self_test(int64_t periods, const double *ad, const double *bd, int64_t *h)
{
    uint32_t cells = 0x3FF;
    double x = 0.0, v = 0.0;
    int32_t chips[16] = {0};
    for (int64_t p = 0; p < periods; p++) {
        int64_t sums[16] = {0};
        for (int n = 0; n < 1023; n++) {
            int32_t bit = (cells >> 9) & 1;
            int32_t chip = 2 * bit - 1;
            uint32_t feedback = ((cells >> 6) ^ (cells >> 9)) & 1;
            double y = rint(1e6 * x / 1.0 * 32768.0);
            int32_t code = (int32_t)(y < -32768.0 ? -32768.0 : y > 32767.0 ? 32767.0 : y);
            for (int k = 15; k > 0; k--)
                chips[k] = chips[k - 1];
            chips[0] = chip;
            for (int k = 0; k < 16; k++)
                sums[k] += chips[k] * code;
            double force = 1e-6 * chip;
            double next = ad[0] * x + ad[1] * v + bd[0] * force;
            v = ad[2] * x + ad[3] * v + bd[1] * force;
            x = next;
            cells = ((cells << 1) | feedback) & 0x3FF;
        }
        for (int k = 0; k < 16; k++)
            h[16 * p + k] = sums[k];
    }
}

/* Workload W1, the digital closed-loop quartz accelerometer, with the operations in the stated order.
   ad[4], bd[2]: exact hold of the pendulum; record: n output codes. */
#include <math.h>
#include <stdint.h>

void closed_loop(int64_t n, const double *ad, const double *bd, int32_t *record)
{
    const double pi = 3.14159265358979323846, rate = 50e3, ts = 1.0 / rate;
    const double alpha = exp(-2.0 * pi * 2000.0 * ts);
    double theta = 0.0, omega = 0.0, integral = 0.0, derivative = 0.0, last = 0.0;
    for (int64_t i = 0; i < n; i++) {
        double a_in = 9.80665 * (0.5 + 0.1 * sin(2.0 * pi * 10.0 * (double)i * ts));
        double v = 8.0e3 * theta;
        double code = rint(v / 5.0 * 8388608.0);
        code = code < -8388608.0 ? -8388608.0 : code > 8388607.0 ? 8388607.0 : code;
        double e = -code;
        integral += 6.0 * ts * e;
        derivative = alpha * derivative + 2.0e-5 / ts * (1.0 - alpha) * (e - last);
        last = e;
        double u = 0.06 * e + integral + derivative;
        double out = rint(u);
        out = out < -524288.0 ? -524288.0 : out > 524287.0 ? 524287.0 : out;
        double drift = 200e-6 * (double)i / (double)n;
        double v_da = out * 2.5 * (1.0 + drift) / 524288.0;
        double current = v_da / 342.0;
        double torque = 8.0e-6 * a_in + 0.065 * current;
        double next = ad[0] * theta + ad[1] * omega + bd[0] * torque;
        omega = ad[2] * theta + ad[3] * omega + bd[1] * torque;
        theta = next;
        record[i] = (int32_t)out;
    }
}

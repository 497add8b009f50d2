/* Workload W3: runs of W1 with parameters of their own, mean and standard deviation of the code over the second half.
   One row of parameters a run: gain, adc reference, dac reference, resistance, torque constant, ad[4], bd[2]. */
#include <math.h>
#include <stdint.h>

void monte_carlo(int64_t runs, int64_t n, const double *parameters, double *result)
{
    const double pi = 3.14159265358979323846, rate = 50e3, ts = 1.0 / rate;
    const double alpha = exp(-2.0 * pi * 2000.0 * ts);
    for (int64_t run = 0; run < runs; run++) {
        const double *p = parameters + 11 * run;
        const double gain = p[0], adc = p[1], dac = p[2], resistance = p[3], kt = p[4];
        const double *ad = p + 5, *bd = p + 9;
        double theta = 0.0, omega = 0.0, integral = 0.0, derivative = 0.0, last = 0.0, sum = 0.0, squares = 0.0;
        for (int64_t i = 0; i < n; i++) {
            double a_in = 9.80665 * (0.5 + 0.1 * sin(2.0 * pi * 10.0 * (double)i * ts));
            double v = gain * theta;
            double code = rint(v / adc * 8388608.0);
            code = code < -8388608.0 ? -8388608.0 : code > 8388607.0 ? 8388607.0 : code;
            double e = -code;
            integral += 6.0 * ts * e;
            derivative = alpha * derivative + 2.0e-5 / ts * (1.0 - alpha) * (e - last);
            last = e;
            double u = 0.06 * e + integral + derivative;
            double out = rint(u);
            out = out < -524288.0 ? -524288.0 : out > 524287.0 ? 524287.0 : out;
            double drift = 200e-6 * (double)i / (double)n;
            double v_da = out * dac * (1.0 + drift) / 524288.0;
            double current = v_da / resistance;
            double torque = 8.0e-6 * a_in + kt * current;
            double next = ad[0] * theta + ad[1] * omega + bd[0] * torque;
            omega = ad[2] * theta + ad[3] * omega + bd[1] * torque;
            theta = next;
            if (i >= n / 2) {
                sum += out;
                squares += out * out;
            }
        }
        const double m = (double)(n - n / 2), mean = sum / m;
        result[2 * run] = mean;
        result[2 * run + 1] = sqrt(squares / m - mean * mean);
    }
}

/* The two-mode gyroscope with gap-closing drive: Runge-Kutta 4, the operations in the order of the graph.
   drive[n], rotation[n]: voltage and rate of rotation, held over each tick; record: n displacements of the sense mode. */
#include <stdint.h>

static inline void rates(double v, double turn, const double *x, double *r)
{
    const double m = 48.67e-9, bias = 15.0, capacitance = 0.05e-12, gap = 4e-6;
    double on_sense = -(2.0 * m * turn * x[1]), coriolis = 2.0 * m * turn * x[3];
    double near = (bias + v) / (1.0 - x[0] / gap), far = (bias - v) / (1.0 + x[0] / gap);
    double on_drive = 0.5 * capacitance / gap * (near * near - far * far) + coriolis;
    r[0] = x[1];
    r[1] = (on_drive - 18.9e-6 * x[1] - 122.28 * x[0]) / m;
    r[2] = x[3];
    r[3] = (on_sense - 57e-6 * x[3] - 132.23 * x[2]) / m;
}

void gyroscope(int64_t n, int64_t substeps, double period, const double *drive, const double *rotation, double *record)
{
    double x[4] = {0.0, 0.0, 0.0, 0.0}, y[4], a[4], b[4], c[4], d[4], h = period / substeps;
    for (int64_t i = 0; i < n; i++) {
        record[i] = x[2];
        for (int64_t s = 0; s < substeps; s++) {
            rates(drive[i], rotation[i], x, a);
            for (int j = 0; j < 4; j++) y[j] = x[j] + h * (0.5 * a[j]);
            rates(drive[i], rotation[i], y, b);
            for (int j = 0; j < 4; j++) y[j] = x[j] + h * (0.5 * b[j]);
            rates(drive[i], rotation[i], y, c);
            for (int j = 0; j < 4; j++) y[j] = x[j] + h * c[j];
            rates(drive[i], rotation[i], y, d);
            for (int j = 0; j < 4; j++)
                x[j] = x[j] + h * (1.0 / 6.0 * a[j] + 1.0 / 3.0 * b[j] + 1.0 / 3.0 * c[j] + 1.0 / 6.0 * d[j]);
        }
    }
}

/* A Kalman filter for random_walk.toml that reads and writes binary frames (docs/formats.md):
   credence world random_walk.toml --frames | ./my_filter | credence check - */
#include <stdio.h>

int main(void) {
  const double Q = 0.04, R = 0.25, P0 = 1.0;
  char line[4096];
  double in[5], x = 0.0, P = 0.0; /* run, step, prior.x, truth.x, measurement.1 */
  while (fgets(line, sizeof line, stdin) && line[0] == '#') continue; /* the last line read names the columns */
  fputs("# credence frames 1\nrun,step,estimate.x,truth.x,P.1.1,innovation.1,S.1.1\n", stdout);
  while (fread(in, sizeof in, 1, stdin) == 1) {
    if (in[1] == 0.0) { /* the start */
      x = in[2];
      P = P0;
      continue;
    }
    P += Q;
    const double nu = in[4] - x, S = P + R;
    x += P / S * nu;
    P -= P * P / S;
    const double out[] = {in[0], in[1], x, in[3], P, nu, S};
    fwrite(out, sizeof out, 1, stdout);
  }
  return 0;
}

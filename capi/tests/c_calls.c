/* Calls every function of the library as a simulation code would, and ends with 1 where an answer is not the expected one.
 *
 * With --time it prints the nanoseconds of a call of wetcor_restitution instead. */
#define _POSIX_C_SOURCE 200809L
#include "wetcor.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static int faults = 0;

#define CHECK(condition)                                                     \
    do {                                                                     \
        if (!(condition)) {                                                  \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);  \
            faults++;                                                        \
        }                                                                    \
    } while (0)

static int close_to(double a, double b) { return fabs(a - b) <= 1e-13 * (1.0 + fabs(b)); }

/* e^2 of each kind of law, said once more in C */
static double e_of(double dry, double loss, double beta, double kappa, double v) {
    double kept = dry * dry - loss + beta / v - kappa / (v * v);
    return kept > 0.0 ? sqrt(kept) : 0.0;
}

static double dry_of(double k, int order, double v) {
    double z = k * pow(v, 0.2);
    double dry = order == 2 ? 1.0 - z + 0.6 * z * z : 1.0 - z;
    return dry;
}

static void laws_from_numbers(void) {
    wetcor_law law;
    double e, slope, threshold, v;
    CHECK(sizeof(wetcor_law) == 56);
    for (v = 0.01; v < 3.0; v *= 1.17) {
        CHECK(wetcor_law_from_alpha_beta(0.53, -0.31, &law) == WETCOR_OK);
        CHECK(wetcor_restitution(&law, v, &e) == WETCOR_OK && close_to(e, e_of(sqrt(0.53), 0.0, -0.31, 0.0, v)));
        CHECK(wetcor_law_reference(0.53, -0.31, 0.002, &law) == WETCOR_OK);
        CHECK(wetcor_restitution(&law, v, &e) == WETCOR_OK && close_to(e, e_of(sqrt(0.53), 0.0, -0.31, 0.002, v)));
        for (int order = 1; order <= 2; order++) {
            CHECK(wetcor_law_impact(0.183, order, 0.06, -0.11, 1e-4, &law) == WETCOR_OK);
            CHECK(wetcor_restitution(&law, v, &e) == WETCOR_OK);
            CHECK(close_to(e, e_of(dry_of(0.183, order, v), 0.06, -0.11, 1e-4, v)));
            CHECK(wetcor_law_dry(0.183, order, &law) == WETCOR_OK);
            CHECK(wetcor_restitution(&law, v, &e) == WETCOR_OK && close_to(e, dry_of(0.183, order, v)));
        }
        /* the slope against a difference */
        if (wetcor_log_slope(&law, v, &slope) == WETCOR_OK) {
            double more, less;
            CHECK(wetcor_restitution(&law, v * exp(1e-5), &more) == WETCOR_OK);
            CHECK(wetcor_restitution(&law, v * exp(-1e-5), &less) == WETCOR_OK);
            CHECK(fabs(log(more / less) / 2e-5 - slope) < 1e-6);
        } else {
            CHECK(0);
        }
    }
    CHECK(wetcor_law_from_alpha_beta(0.53, -0.31, &law) == WETCOR_OK);
    CHECK(wetcor_threshold_speed(&law, &threshold) == WETCOR_OK && close_to(threshold, 0.31 / 0.53));
    CHECK(wetcor_log_slope(&law, 0.9 * threshold, &slope) == WETCOR_NO_REBOUND && isnan(slope));
    CHECK(wetcor_log_slope(&law, 1.0, &slope) == WETCOR_OK && close_to(slope, 0.31 / (2.0 * 0.22)));
    CHECK(wetcor_law_from_alpha_beta(-0.1, -0.31, &law) == WETCOR_OK);
    CHECK(wetcor_threshold_speed(&law, &threshold) == WETCOR_OK && isinf(threshold));
    CHECK(wetcor_law_dry(0.183, 1, &law) == WETCOR_OK);
    CHECK(wetcor_threshold_speed(&law, &threshold) == WETCOR_OK && threshold == 0.0);
    /* the least speed there is */
    CHECK(wetcor_restitution(&law, 2.3e-308, &e) == WETCOR_OK && close_to(e, 1.0));
    CHECK(wetcor_restitution(&law, 1.7e308, &e) == WETCOR_OK && e == 0.0);
}

static void range_of_runs(void) {
    wetcor_law law, before;
    double e, least, most;
    CHECK(wetcor_law_from_alpha_beta(0.53, -0.31, &law) == WETCOR_OK);
    CHECK(wetcor_range(&law, &least, &most) == WETCOR_OK && least == 0.0 && isinf(most));
    CHECK(wetcor_law_set_range(&law, 0.7, 1.4) == WETCOR_OK);
    CHECK(wetcor_range(&law, &least, &most) == WETCOR_OK && least == 0.7 && most == 1.4);
    CHECK(wetcor_restitution(&law, 0.7, &e) == WETCOR_OK && wetcor_restitution(&law, 1.4, &e) == WETCOR_OK);
    CHECK(wetcor_restitution(&law, 0.69, &e) == WETCOR_EXTRAPOLATED && close_to(e, sqrt(0.53 - 0.31 / 0.69)));
    CHECK(wetcor_log_slope(&law, 1.5, &e) == WETCOR_EXTRAPOLATED && e > 0.0);
    before = law;
    CHECK(wetcor_law_set_range(&law, 1.4, 0.7) == WETCOR_BAD_NUMBER);
    CHECK(wetcor_law_set_range(&law, NAN, 0.7) == WETCOR_BAD_NUMBER);
    CHECK(memcmp(&law, &before, sizeof law) == 0);
}

static void refusals(void) {
    wetcor_law law, zeroed;
    double e = 3.0, f = 3.0;
    memset(&zeroed, 0, sizeof zeroed);
    CHECK(wetcor_law_from_alpha_beta(0.53, -0.31, NULL) == WETCOR_BAD_POINTER);
    CHECK(wetcor_law_dry(0.1, 1, NULL) == WETCOR_BAD_POINTER);
    CHECK(wetcor_restitution(NULL, 1.0, &e) == WETCOR_BAD_POINTER && isnan(e));
    CHECK(wetcor_restitution(NULL, 1.0, NULL) == WETCOR_BAD_POINTER);
    CHECK(wetcor_law_set_range(NULL, 0.0, 1.0) == WETCOR_BAD_POINTER);
    CHECK(wetcor_law_set_range(&zeroed, 0.0, 1.0) == WETCOR_BAD_LAW);
    e = 3.0;
    CHECK(wetcor_restitution(&zeroed, 1.0, &e) == WETCOR_BAD_LAW && isnan(e));
    CHECK(wetcor_log_slope(&zeroed, 1.0, &e) == WETCOR_BAD_LAW);
    CHECK(wetcor_threshold_speed(&zeroed, &e) == WETCOR_BAD_LAW);
    e = 3.0;
    CHECK(wetcor_range(&zeroed, &e, &f) == WETCOR_BAD_LAW && isnan(e) && isnan(f));
    /* what gains energy, and what is no number; the law is then refused, too */
    CHECK(wetcor_law_from_alpha_beta(1.01, -0.31, &law) == WETCOR_BAD_NUMBER);
    CHECK(wetcor_restitution(&law, 1.0, &e) == WETCOR_BAD_LAW);
    CHECK(wetcor_law_from_alpha_beta(0.5, 0.01, &law) == WETCOR_BAD_NUMBER);
    CHECK(wetcor_law_from_alpha_beta(NAN, -0.31, &law) == WETCOR_BAD_NUMBER);
    CHECK(wetcor_law_from_alpha_beta(0.5, -INFINITY, &law) == WETCOR_BAD_NUMBER);
    CHECK(wetcor_law_reference(0.5, -0.31, -0.1, &law) == WETCOR_BAD_NUMBER);
    CHECK(wetcor_law_impact(0.1, 1, -0.01, -0.1, 0.0, &law) == WETCOR_BAD_NUMBER);
    CHECK(wetcor_law_dry(-0.1, 1, &law) == WETCOR_BAD_NUMBER);
    CHECK(wetcor_law_dry(0.1, 0, &law) == WETCOR_BAD_NUMBER);
    CHECK(wetcor_law_dry(0.1, 3, &law) == WETCOR_BAD_NUMBER);
    CHECK(wetcor_law_from_alpha_beta(0.53, -0.31, &law) == WETCOR_OK);
    CHECK(wetcor_restitution(&law, 1.0, NULL) == WETCOR_BAD_POINTER);
    CHECK(wetcor_log_slope(&law, 1.0, NULL) == WETCOR_BAD_POINTER);
    CHECK(wetcor_threshold_speed(&law, NULL) == WETCOR_BAD_POINTER);
    CHECK(wetcor_range(&law, &e, NULL) == WETCOR_BAD_POINTER && wetcor_range(&law, NULL, &e) == WETCOR_BAD_POINTER);
    const double no_speed[] = {0.0, -0.0, -1.0, 5e-324, NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < sizeof no_speed / sizeof *no_speed; i++) {
        e = 3.0;
        CHECK(wetcor_restitution(&law, no_speed[i], &e) == WETCOR_BAD_SPEED && isnan(e));
        CHECK(wetcor_log_slope(&law, no_speed[i], &e) == WETCOR_BAD_SPEED);
    }
    law.dry_order = 7;
    CHECK(wetcor_restitution(&law, 1.0, &e) == WETCOR_BAD_LAW);
}

static const char HEADER[] =
    "particle,liquid,diameter_m,film_m,film_ratio,law,dry_k,dry_order,inertial_loss,alpha,beta_m_s,kappa_m2_s2,"
    "threshold_speed_m_s,min_speed_m_s,max_speed_m_s,source,quotable\n";

static wetcor_status of_line(const char *line, wetcor_law *law) { return wetcor_law_from_csv(HEADER, line, law); }

static void laws_from_a_table(void) {
    wetcor_law law, other;
    double e, least, most;
    CHECK(of_line("PTFE,M50,0.004762,0.000286,0.06,reference,0.183,1,0.1,0.53,-0.31,,0.58,0.7,1.4,posterior,true\r\n",
                  &law) == WETCOR_OK);
    CHECK(wetcor_law_reference(0.53, -0.31, 0.0, &other) == WETCOR_OK);
    CHECK(wetcor_law_set_range(&other, 0.7, 1.4) == WETCOR_OK && memcmp(&law, &other, sizeof law) == 0);
    CHECK(of_line("PTFE,M50,0.004762,0.000286,0.06,impact,0.183,2,0.1,,-0.31,1e-4,0.58,,,posterior,false", &law) ==
          WETCOR_NOT_QUOTABLE);
    CHECK(wetcor_law_impact(0.183, 2, 0.1, -0.31, 1e-4, &other) == WETCOR_OK);
    CHECK(memcmp(&law, &other, sizeof law) == 0);
    CHECK(of_line("PTFE,dry,0.004762,,,dry,0.183,1,,,,,0,0.2,,dry fit,true", &law) == WETCOR_OK);
    CHECK(wetcor_restitution(&law, 1.0, &e) == WETCOR_OK && close_to(e, 1.0 - 0.183));
    CHECK(wetcor_range(&law, &least, &most) == WETCOR_OK && least == 0.2 && isinf(most));
    /* columns are found by their names */
    CHECK(wetcor_law_from_csv("\xef\xbb\xbfquotable,new,beta_m_s,alpha,law,kappa_m2_s2,min_speed_m_s,max_speed_m_s",
                              "true,x,-0.31,0.53,reference,,,", &law) == WETCOR_OK);
    CHECK(wetcor_restitution(&law, 1.0, &e) == WETCOR_OK && close_to(e, sqrt(0.53 - 0.31)));
    CHECK(wetcor_law_from_csv("quotable,alpha,law,kappa_m2_s2,min_speed_m_s,max_speed_m_s",
                              "true,0.53,reference,,,", &law) == WETCOR_MISSING_COLUMN);
    CHECK(wetcor_restitution(&law, 1.0, &e) == WETCOR_BAD_LAW);
    /* another number of cells, a number that is none, an unknown law or word, a quoted name, an empty alpha */
    CHECK(of_line("PTFE,dry,0.004762,,,dry,0.183,1,,,,,0,0.2,,dry fit", &law) == WETCOR_BAD_LINE);
    CHECK(of_line("PTFE,dry,0.004762,,,dry,0.18x,1,,,,,0,0.2,,dry fit,true", &law) == WETCOR_BAD_LINE);
    CHECK(of_line("PTFE,dry,0.004762,,,dry,,1,,,,,0,0.2,,dry fit,true", &law) == WETCOR_BAD_LINE);
    CHECK(of_line("PTFE,dry,0.004762,,,dry,0.183,3,,,,,0,0.2,,dry fit,true", &law) == WETCOR_BAD_LINE);
    CHECK(of_line("PTFE,dry,0.004762,,,wet,0.183,1,,,,,0,0.2,,dry fit,true", &law) == WETCOR_BAD_LINE);
    CHECK(of_line("PTFE,dry,0.004762,,,dry,0.183,1,,,,,0,0.2,,dry fit,yes", &law) == WETCOR_BAD_LINE);
    CHECK(of_line("\"PTFE\",dry,0.004762,,,dry,0.183,1,,,,,0,0.2,,dry fit,true", &law) == WETCOR_BAD_LINE);
    CHECK(of_line("P,M50,1,1,1,reference,0.183,1,0.1,,-0.31,,0.58,0.7,1.4,posterior,true", &law) == WETCOR_BAD_LINE);
    CHECK(of_line("", &law) == WETCOR_BAD_LINE && of_line("\xff\xfe", &law) == WETCOR_BAD_LINE);
    CHECK(of_line("PTFE,dry,0.004762,,,dry,\xff,1,,,,,0,0.2,,dry fit,true", &law) == WETCOR_BAD_LINE);
    CHECK(of_line("P,dry,1,,,dry,nan,1,,,,,0,0.2,,dry fit,true", &law) == WETCOR_BAD_NUMBER);
    CHECK(of_line("P,dry,1,,,dry,0.1,1,,,,,0,0.2,0.1,dry fit,true", &law) == WETCOR_BAD_NUMBER);
    CHECK(wetcor_law_from_csv(NULL, "", &law) == WETCOR_BAD_POINTER);
    CHECK(wetcor_law_from_csv("", NULL, &law) == WETCOR_BAD_POINTER);
    CHECK(of_line("", NULL) == WETCOR_BAD_POINTER);
}

static void texts(void) {
    for (int status = -8; status <= 2; status++) {
        CHECK(strcmp(wetcor_status_text(status), wetcor_status_text(99)) != 0);
    }
    CHECK(strcmp(wetcor_status_text(-9), wetcor_status_text(99)) == 0);
    CHECK(strlen(wetcor_version()) >= 5);
}

/* one law read by several threads at once */
static wetcor_law shared;

static void *sum_of_all(void *sum) {
    for (int i = 1; i <= 20000; i++) {
        double e;
        if (wetcor_restitution(&shared, 1e-4 * i, &e) == WETCOR_OK) {
            *(double *)sum += e;
        }
    }
    return NULL;
}

static void threads(void) {
    enum { COUNT = 4 };
    pthread_t thread[COUNT];
    double sum[COUNT] = {0}, alone = 0.0;
    CHECK(wetcor_law_impact(0.183, 1, 0.06, -0.11, 1e-4, &shared) == WETCOR_OK);
    sum_of_all(&alone);
    for (int i = 0; i < COUNT; i++) {
        CHECK(pthread_create(&thread[i], NULL, sum_of_all, &sum[i]) == 0);
    }
    for (int i = 0; i < COUNT; i++) {
        CHECK(pthread_join(thread[i], NULL) == 0 && sum[i] == alone);
    }
    CHECK(alone > 1000.0);
}

enum { SPEEDS = 1000, ROUNDS = 1000, TIMES = 50 };
static double speeds[SPEEDS];

/* ns of a call, of wetcor_restitution or where there is no law of pow, for comparison: the least of many short
 * measurements, in the processor's time, since other programs take part of the rest */
static double nanoseconds(const wetcor_law *law) {
    double least = INFINITY, sum = 0.0;
    for (int time = 0; time < TIMES; time++) {
        struct timespec from, to;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &from);
        for (int i = 0; i < ROUNDS; i++) {
            for (int j = 0; j < SPEEDS; j++) {
                double e;
                if (law) {
                    wetcor_restitution(law, speeds[j], &e);
                } else {
                    e = pow(speeds[j], 0.2);
                }
                sum += e;
            }
        }
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &to);
        double passed = (to.tv_sec - from.tv_sec) * 1e9 + (to.tv_nsec - from.tv_nsec);
        least = fmin(least, passed / ROUNDS / SPEEDS);
    }
    return sum > 0.0 ? least : NAN;
}

static void print_times(void) {
    wetcor_law law;
    for (int i = 0; i < SPEEDS; i++) {
        speeds[i] = 0.05 + 2.0 * i / SPEEDS;
    }
    wetcor_law_reference(0.53, -0.03, 1e-4, &law);
    printf("reference %.2f ns\n", nanoseconds(&law));
    wetcor_law_impact(0.183, 1, 0.06, -0.03, 1e-4, &law);
    printf("impact %.2f ns\n", nanoseconds(&law));
    wetcor_law_impact(0.183, 2, 0.06, -0.03, 1e-4, &law);
    printf("impact, second order %.2f ns\n", nanoseconds(&law));
    wetcor_law_dry(0.183, 1, &law);
    printf("dry %.2f ns\n", nanoseconds(&law));
    printf("pow(v, 0.2), for comparison %.2f ns\n", nanoseconds(NULL));
}

int main(int count, char **arguments) {
    if (count > 1 && strcmp(arguments[1], "--time") == 0) {
        print_times();
        return 0;
    }
    laws_from_numbers();
    range_of_runs();
    refusals();
    laws_from_a_table();
    texts();
    threads();
    return faults > 0;
}

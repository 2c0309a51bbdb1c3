// Two islands of an atlas, sampled by the program's own threads, filtered, with exact energy for each. C++17.
#include "pmcip.h"

#include <cmath>
#include <cstdio>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

constexpr std::uint32_t width = 96, height = 64;
constexpr std::size_t pixels = width * height, room = 512;

static void expect(pmcip_status status) {
    if (status != PMCIP_STATUS_OK)
        throw std::runtime_error(pmcip_message(status));
}

// Memory for something of the library's.
using Memory = std::vector<unsigned char>;

// What a thread needs for itself.
struct Worker {
    Memory memory = Memory(pmcip_job_size());
    std::vector<float> x = std::vector<float>(room), y = x, u = x, v = x, rgb = std::vector<float>(3 * room);
    std::vector<std::uint32_t> index = std::vector<std::uint32_t>(room), key = index;

    void take(pmcip_job *job) {
        for (std::size_t n;;) {
            expect(pmcip_job_plan(job, room, x.data(), y.data(), index.data(), key.data(), &n));
            if (n == 0)
                return;
            expect(pmcip_points(1, n, index.data(), key.data(), u.data(), v.data()));
            for (std::size_t i = 0; i < n; i++) {
                float value = x[i] < width / 2 ? 2 * u[i] : (u[i] < 0.1f ? 100 * v[i] : 0);
                rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = value;
            }
            expect(pmcip_job_deliver(job, rgb.data(), n));
        }
    }
};

static void iterate(pmcip_film *film, std::uint64_t samples) {
    expect(pmcip_film_begin(film, samples));
    Memory memory(pmcip_jobs_size());
    pmcip_jobs *jobs;
    expect(pmcip_jobs_begin(film, memory.data(), memory.size(), &jobs));
    std::mutex next;
    auto work = [&] {
        Worker worker;
        for (pmcip_job *job;; worker.take(job)) {
            std::lock_guard lock(next);
            if (pmcip_jobs_next(jobs, worker.memory.data(), worker.memory.size(), &job) == PMCIP_STATUS_DONE)
                return;
        }
    };
    std::vector<std::thread> threads;
    for (int i = 0; i < 3; i++)
        threads.emplace_back(work);
    for (auto &thread : threads)
        thread.join();
    expect(pmcip_film_end(film, nullptr));
}

int main() {
    std::vector<std::uint16_t> labels(pixels);
    for (std::size_t i = 0; i < pixels; i++)
        labels[i] = i % width < 40 ? 1 : i % width < 50 ? 0 : 2;
    pmcip_settings settings;
    expect(pmcip_settings_new(width, height, 2, 16, &settings));
    Memory memory(pmcip_film_size(width, height, 1));
    pmcip_film *film;
    expect(pmcip_film_create(memory.data(), memory.size(), &settings, labels.data(), &film));
    const std::uint64_t used = pmcip_film_pixels(film);
    for (int i = 0; i < 8; i++)
        iterate(film, 2 * used);

    std::vector<float> scratch(pmcip_scratch_size(width, height)), wide(pmcip_filter_size(width, height, 1));
    std::vector<float> guide(3 * pixels), rgb(3 * pixels), fair(3 * pixels);
    expect(pmcip_film_filter(film, nullptr, wide.data(), wide.size(), guide.data()));
    expect(pmcip_film_resolve_guided(film, guide.data(), scratch.data(), scratch.size(), rgb.data()));
    expect(pmcip_film_resolve(film, PMCIP_ESTIMATOR_DIFFERENCE, scratch.data(), scratch.size(), fair.data()));
    std::vector<std::uint32_t> count(pixels);
    expect(pmcip_film_count(film, count.data()));
    double energy[3] = {}, wanted[3] = {}, spent[3] = {};
    for (std::size_t i = 0; i < pixels; i++) {
        energy[labels[i]] += rgb[3 * i];
        wanted[labels[i]] += fair[3 * i];
        spent[labels[i]] += count[i];
    }
    std::printf("energy %.1f and %.1f, samples %.0f and %.0f\n", energy[1], energy[2], spent[1], spent[2]);
    const bool exact = std::abs(energy[1] / wanted[1] - 1) < 1e-4 && std::abs(energy[2] / wanted[2] - 1) < 1e-4;
    return exact && spent[0] == 0 && spent[1] + spent[2] == 16.0 * used && spent[2] > spent[1] ? 0 : 1;
}

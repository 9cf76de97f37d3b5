#include "reports/document/judged_filter.h"

#include <utility>

#include "reports/document/judged.h"
#include "reports/render/text_page.h"
#include "reports/render/write_document.h"

namespace credence {

JudgedFilter::JudgedFilter(Judged judged) : judged_(std::make_shared<const Judged>(std::move(judged))) {}

Verdict JudgedFilter::verdict() const { return judged_->verdict; }
double JudgedFilter::p_value() const { return judged_->p_value; }
const std::string& JudgedFilter::says() const { return judged_->says; }
const Factor& JudgedFilter::factor() const { return judged_->factor; }
const std::vector<NamedCause>& JudgedFilter::causes() const { return judged_->causes; }
const std::vector<FailedRun>& JudgedFilter::failures() const { return judged_->failures; }
bool JudgedFilter::complete() const { return judged_->complete; }

std::string JudgedFilter::text() const { return text_page(judged_->document); }

std::string JudgedFilter::json() const { return judged_->document.json(); }

void JudgedFilter::write_report(const std::filesystem::path& directory) const {
  write_document(judged_->document, directory);
}

}  // namespace credence
